"""Reads numbers that are never parameters: angles of a placement, limits of a joint."""

from __future__ import annotations

import math

from symdyn.base.units import UnitError, quantity_in_si
from symdyn.base.wording import quoted
from symdyn.spec.findings import Findings
from symdyn.spec.schema import Scalar
from symdyn.spec.toml_positions import KeyPath


def plain_number(value: Scalar, unit: str, path: KeyPath, findings: Findings) -> float:
    """A number in SI, or a text with a unit of the dimension of ``unit``; 0 after an error, which is told."""
    if not isinstance(value, str):
        return float(value)
    try:
        number = quantity_in_si(value, unit)
    except UnitError as error:
        findings.error(path, error.code, error.message, error.hint)
        return 0.0
    if not math.isfinite(number):
        findings.error(path, "SD201", "a number must be finite")
        return 0.0
    return number


def plain_angle(value: Scalar, path: KeyPath, findings: Findings) -> float:
    """An angle in radians; more than a turn is told as doubtful."""
    angle = plain_number(value, "rad", path, findings)
    if abs(angle) > 2 * math.pi:
        hint = f'for degrees write "{value} deg"' if not isinstance(value, str) else ""
        findings.warning(path, "SD223", f"angle {quoted(value)} is {angle:.4g} rad, more than a turn", hint)
    return angle
