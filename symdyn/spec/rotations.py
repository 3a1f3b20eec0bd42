"""Rotation matrices of placements, as numbers: from roll, pitch and yaw, onto an axis, with exact zeros and ones."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from symdyn.spec.records import Rotation, Three

Array = npt.NDArray[np.float64]

EXACT = 1e-9  # an entry this near to 0, 1 or -1 is meant to be it: a rotation by multiples of a right angle


def from_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """(3, 3) turn by roll about x, then pitch about y, then yaw about z, about fixed axes: Rz Ry Rx."""
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    return snapped(
        np.array(
            [
                [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                [-sp, cp * sr, cp * cr],
            ]
        )
    )


def onto(axis: Array) -> Array:
    """(3, 3) the smallest turn that brings z onto a unit vector (3,); half a turn about x for -z."""
    x, y, z = (float(entry) for entry in axis)
    if z < -1 + EXACT:
        return np.diag([1.0, -1.0, -1.0])
    skew = np.array([[0.0, 0.0, x], [0.0, 0.0, y], [-x, -y, 0.0]])
    return snapped(np.eye(3) + skew + skew @ skew / (1 + z))


def snapped(rotation: Array) -> Array:
    """The rotation with entries that are 0 or +-1, but for rounding, made exactly so."""
    nearest = np.round(rotation)
    result: Array = np.where(np.abs(rotation - nearest) < EXACT, nearest, rotation) + 0.0
    return result


def is_rotation(matrix: Array, tolerance: float = 1e-6) -> bool:
    """Whether the columns are perpendicular unit vectors of a right-handed frame."""
    return bool(np.abs(matrix.T @ matrix - np.eye(3)).max() < tolerance and np.linalg.det(matrix) > 0)


def as_record(rotation: Array) -> Rotation:
    """The matrix as the tuples that a Placement holds."""
    rows: list[Three] = [(float(x), float(y), float(z)) for x, y, z in snapped(rotation)]
    return rows[0], rows[1], rows[2]
