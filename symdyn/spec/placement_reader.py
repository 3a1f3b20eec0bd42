"""Reads placements: xyz and rpy (or a rotation matrix) of a joint, of the base, of the tool."""

from __future__ import annotations

import numpy as np

from symdyn.spec.findings import Findings
from symdyn.spec.numbers import NumberReader
from symdyn.spec.plain_numbers import plain_angle
from symdyn.spec.records import Placement
from symdyn.spec.rotations import Array, as_record, from_rpy, is_rotation
from symdyn.spec.schema import PlacementTable
from symdyn.spec.slots import position_slots
from symdyn.spec.toml_positions import KeyPath


def read_placement(table: PlacementTable, path: KeyPath, owner: str, numbers: NumberReader) -> Placement:
    """The placement of a joint, or of ``base`` or ``tool``; without a turn after an error, which is told."""
    x, y, z = (numbers.read(value, slot) for value, slot in zip(table.xyz, position_slots(path, owner), strict=True))
    return Placement((x, y, z), as_record(_rotation(table, path, numbers.findings)))


def _rotation(table: PlacementTable, path: KeyPath, findings: Findings) -> Array:
    if table.rotation is None:
        angles = table.rpy or [0, 0, 0]
        roll, pitch, yaw = (plain_angle(angle, (*path, "rpy", i), findings) for i, angle in enumerate(angles))
        return from_rpy(roll, pitch, yaw)
    if table.rpy is not None:
        findings.error((*path, "rotation"), "SD105", "both `rpy` and `rotation` are given", "keep one of them")
    matrix = np.array(table.rotation)
    if not is_rotation(matrix):
        findings.error(
            (*path, "rotation"),
            "SD112",
            "this matrix is no rotation",
            "its rows are perpendicular unit vectors, right-handed",
        )
        return np.eye(3)
    return matrix
