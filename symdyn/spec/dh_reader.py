"""Reads the Denavit-Hartenberg table: which column of each row moves, and the constants of the others."""

from __future__ import annotations

import math
import re

from symdyn.base.wording import quoted
from symdyn.spec.frames import JointFrame
from symdyn.spec.numbers import NumberReader, Slot
from symdyn.spec.records import DHRow, JointKind, Monomial
from symdyn.spec.schema import DHTable, Scalar
from symdyn.spec.toml_positions import KeyPath

COLUMNS = ("theta", "d", "a", "alpha")
_ANGLES = ("theta", "alpha")
_VARIABLE = re.compile(r"\s*q(?:\s*(?P<sign>[+-])\s*(?P<offset>[^\s+-].*))?", re.ASCII)
_KINDS = {"theta": JointKind.REVOLUTE, "d": JointKind.PRISMATIC}
_SYMBOLS = {"theta": r"\theta", "d": "d", "a": "a", "alpha": r"\alpha"}


def read_dh(table: DHTable, joint_names: tuple[str, ...], numbers: NumberReader) -> tuple[JointFrame, ...] | None:
    """One frame per joint; None where the table does not tell the kind of every joint (SD105)."""
    findings = numbers.findings
    rows_path: KeyPath = ("dh", "rows")
    if len(table.rows) != len(joint_names):
        findings.error(
            rows_path,
            "SD105",
            f"{len(table.rows)} DH rows for {len(joint_names)} joints",
            "one row [theta, d, a, alpha] for each [[joint]], in the same order",
        )
        return None
    frames = [_read_row(row, (*rows_path, i), joint_names[i], numbers) for i, row in enumerate(table.rows)]
    return None if None in frames else tuple(frame for frame in frames if frame is not None)


def joint_variable_offset(value: Scalar) -> str | None:
    """The offset in ``"q - 0.1 m"`` (``"-0.1 m"``; ``""`` for a bare ``"q"``); None where there is no ``q``."""
    match = _VARIABLE.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        return None
    if match["offset"] is None:
        return ""
    return ("-" if match["sign"] == "-" else "") + match["offset"]


def _read_row(row: list[Scalar], path: KeyPath, joint: str, numbers: NumberReader) -> JointFrame | None:
    if len(row) != len(COLUMNS):
        numbers.findings.error(path, "SD105", f"a DH row has four columns, this one {len(row)}", "[theta, d, a, alpha]")
        return None
    moving = [column for column, value in zip(COLUMNS, row, strict=True) if joint_variable_offset(value) is not None]
    if len(moving) != 1 or moving[0] not in _KINDS:
        numbers.findings.error(
            path,
            "SD105",
            f'a DH row has one "q", in theta (revolute) or in d (prismatic); here: {", ".join(moving) or "none"}',
            'such as ["q", 0, 0, "90 deg"] or [0, "q + 0.1 m", 0, 0]',
        )
        return None
    constants = {
        column: _read_constant(value, column, (*path, i), joint, numbers)
        for i, (column, value) in enumerate(zip(COLUMNS, row, strict=True))
    }
    return JointFrame(_KINDS[moving[0]], DHRow(**constants))


def _read_constant(value: Scalar, column: str, path: KeyPath, joint: str, numbers: NumberReader) -> Monomial:
    offset = joint_variable_offset(value)
    constant: Scalar = value if offset is None else offset or 0
    is_angle = column in _ANGLES
    slot = Slot(path, (joint,), f"dh_{column}", "rad" if is_angle else "m", _SYMBOLS[column], f"DH {column} of {joint}")
    if not is_angle:
        return numbers.read(constant, slot)
    angle = numbers.read_plain(constant, slot)
    radians = numbers.value(angle)
    if radians is not None and abs(radians) > 2 * math.pi:
        numbers.findings.warning(
            path,
            "SD223",
            f"{column} {quoted(value)} is {radians:.4g} rad, more than a turn",
            f'for degrees write "{constant} deg"' if not isinstance(constant, str) else "",
        )
    return angle
