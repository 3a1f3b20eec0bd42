"""Joint frames from Denavit-Hartenberg rows (seed eq. 1-4, the misprints of A_i mended) and placements."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from symdyn.base import symbols
from symdyn.derive.coordinates import Coordinate, joint_coordinates
from symdyn.derive.quantities import angle_expression, expression
from symdyn.spec.records import Convention, DHRow, JointKind, Placement, Robot

_X, _Z = sp.ImmutableMatrix([1, 0, 0]), sp.ImmutableMatrix([0, 0, 1])


@dataclass(frozen=True, slots=True)
class Frame:
    """Link frame i in frame i-1, as both formulations need it.

    ``rotation`` (3, 3) and ``position`` (3,) place frame i in frame i-1. ``axis`` is the joint axis
    in frame i, where it is constant. ``before`` is the part of the position that is fixed in frame
    i-1 (modified convention), ``after`` the part that is fixed in frame i (standard), expressed there;
    each holds the joint displacement of a prismatic joint.
    """

    coordinate: Coordinate
    prismatic: bool
    rotation: sp.Matrix
    position: sp.Matrix
    axis: sp.Matrix
    before: sp.Matrix
    after: sp.Matrix

    @property
    def transform(self) -> sp.Matrix:
        """A_i of seed eq. 3, 4 x 4."""
        return _transform(self.position, self.rotation)


def rotation_x(angle: sp.Expr) -> sp.Matrix:
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[1, 0, 0], [0, c, -s], [0, s, c]])


def rotation_z(angle: sp.Expr) -> sp.Matrix:
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def frames(robot: Robot) -> tuple[Frame, ...]:
    """One frame per joint, from the base outwards."""
    return tuple(
        _row_frame(joint.placement, robot.convention, coordinate, joint.kind is JointKind.PRISMATIC)
        if isinstance(joint.placement, DHRow)
        else _placed_frame(joint.placement, coordinate, joint.kind is JointKind.PRISMATIC)
        for joint, coordinate in zip(robot.joints, joint_coordinates(robot), strict=True)
    )


def _row_frame(row: DHRow, convention: Convention, coordinate: Coordinate, prismatic: bool) -> Frame:
    theta, alpha = angle_expression(row.theta), angle_expression(row.alpha)
    d, a = expression(row.d), expression(row.a)
    if prismatic:
        d += coordinate.q
    else:
        theta += coordinate.q
    twist, turn = rotation_x(alpha), rotation_z(theta)
    if convention is Convention.STANDARD:  # turn and slide along z, then step and twist along x
        axis = twist.T * _Z
        after = a * _X + d * axis
        rotation = turn * twist
        return Frame(coordinate, prismatic, rotation, rotation * after, axis, sp.zeros(3, 1), after)
    before = a * _X + twist * (d * _Z)  # Craig: step and twist along x, then turn and slide along z
    return Frame(coordinate, prismatic, twist * turn, before, _Z, before, sp.zeros(3, 1))


def _placed_frame(placement: Placement, coordinate: Coordinate, prismatic: bool) -> Frame:
    """Step and turn by what is fixed, then turn about or slide along z."""
    before, rotation = fixed(placement)
    if prismatic:
        before = before + rotation * (coordinate.q * _Z)
    else:
        rotation = rotation * rotation_z(coordinate.q)
    return Frame(coordinate, prismatic, rotation, before, _Z, before, sp.zeros(3, 1))


def fixed(placement: Placement | None) -> tuple[sp.Matrix, sp.Matrix]:
    """Position (3,) and rotation (3, 3) of a placement; none is the frame it is placed in."""
    if placement is None:
        return sp.zeros(3, 1), sp.eye(3)
    rotation = sp.Matrix(3, 3, [symbols.number(entry) for row in placement.rotation for entry in row])
    return sp.Matrix([expression(coordinate) for coordinate in placement.position]), rotation


def base_transform(robot: Robot) -> sp.Matrix:
    """The frame in which the first joint is placed, in the world frame, 4 x 4."""
    return _transform(*fixed(robot.base))


def tool_transform(robot: Robot) -> sp.Matrix:
    """The tool's frame in that of the last link, 4 x 4; the identity where there is no tool."""
    return _transform(*fixed(robot.tool.placement if robot.tool is not None else None))


def _transform(position: sp.Matrix, rotation: sp.Matrix) -> sp.Matrix:
    return rotation.row_join(position).col_join(sp.Matrix([[0, 0, 0, 1]]))


def base_transforms(robot: Robot) -> tuple[sp.Matrix, ...]:
    """T_i of every link in the world frame (seed: chain products), 4 x 4 each, not simplified."""
    transform, found = base_transform(robot), []
    for frame in frames(robot):
        transform = transform * frame.transform
        found.append(transform)
    return tuple(found)
