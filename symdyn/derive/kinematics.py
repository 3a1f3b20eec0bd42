"""Joint frames from Denavit-Hartenberg rows (seed eq. 1-4, the misprints of A_i mended)."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from symdyn.derive.coordinates import Coordinate, joint_coordinates
from symdyn.derive.quantities import angle_expression, expression
from symdyn.spec.records import Convention, JointKind, Robot


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
        top = self.rotation.row_join(self.position)
        return top.col_join(sp.Matrix([[0, 0, 0, 1]]))


def rotation_x(angle: sp.Expr) -> sp.Matrix:
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[1, 0, 0], [0, c, -s], [0, s, c]])


def rotation_z(angle: sp.Expr) -> sp.Matrix:
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def frames(robot: Robot) -> tuple[Frame, ...]:
    """One frame per joint, from the base outwards."""
    found = []
    for joint, coordinate in zip(robot.joints, joint_coordinates(robot), strict=True):
        theta, alpha = angle_expression(joint.dh.theta), angle_expression(joint.dh.alpha)
        d, a = expression(joint.dh.d), expression(joint.dh.a)
        prismatic = joint.kind is JointKind.PRISMATIC
        if prismatic:
            d += coordinate.q
        else:
            theta += coordinate.q
        twist, turn = rotation_x(alpha), rotation_z(theta)
        z = sp.Matrix([0, 0, 1])
        x = sp.Matrix([1, 0, 0])
        if robot.convention is Convention.STANDARD:  # turn and slide along z, then step and twist along x
            axis = twist.T * z
            after = a * x + d * axis
            rotation = turn * twist
            frame = Frame(coordinate, prismatic, rotation, rotation * after, axis, sp.zeros(3, 1), after)
        else:  # Craig: step and twist along x, then turn and slide along z
            before = a * x + twist * (d * z)
            frame = Frame(coordinate, prismatic, twist * turn, before, z, before, sp.zeros(3, 1))
        found.append(frame)
    return tuple(found)


def base_transforms(robot: Robot) -> tuple[sp.Matrix, ...]:
    """T_i of every link in the base frame (seed: chain products), 4 x 4 each, not simplified."""
    transform, found = sp.eye(4), []
    for frame in frames(robot):
        transform = transform * frame.transform
        found.append(transform)
    return tuple(found)
