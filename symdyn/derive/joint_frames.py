"""Frames on the joint axes, which the recursions use: z is the axis, whatever convention the robot is written in.

A link frame of the standard convention sits at the far end of its link. Seen from the near end, where the
joint is, standard and modified robots are the same: step and twist along x, then turn or slide along z.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from symdyn.derive.bodies import body
from symdyn.derive.coordinates import Coordinate, joint_coordinates
from symdyn.derive.kinematics import rotation_x
from symdyn.derive.quantities import angle_expression, expression
from symdyn.spec.records import Convention, JointKind, Robot


@dataclass(frozen=True, slots=True)
class JointFrame:
    """Frame i, fixed to link i, its origin on joint axis i and its z along it.

    From frame i-1: shift by ``position`` (3,), turn by the fixed rotation ``twist`` (3, 3), then by
    ``angle`` about z. ``position`` holds the displacement of a prismatic joint, whose ``angle`` is fixed.
    ``pseudo_inertia`` (4, 4) of the link is in frame i.
    """

    coordinate: Coordinate
    prismatic: bool
    twist: sp.Matrix
    angle: sp.Expr
    position: sp.Matrix
    pseudo_inertia: sp.Matrix

    @property
    def axis(self) -> sp.Matrix:
        """The joint axis in frame i-1."""
        return self.twist[:, 2]


def joint_frames(robot: Robot) -> tuple[JointFrame, ...]:
    """One frame per joint, from the base outwards."""
    standard = robot.convention is Convention.STANDARD
    step, twist = sp.zeros(3, 1), sp.eye(3)
    found = []
    for joint, coordinate in zip(robot.joints, joint_coordinates(robot), strict=True):
        theta, d = angle_expression(joint.dh.theta), expression(joint.dh.d)
        along = sp.Matrix([expression(joint.dh.a), 0, 0])
        bend = rotation_x(angle_expression(joint.dh.alpha))
        prismatic = joint.kind is JointKind.PRISMATIC
        if prismatic:
            d += coordinate.q
        else:
            theta += coordinate.q
        inertia = body(joint.link).pseudo_inertia
        if standard:
            inertia = moved(inertia, bend, along)
        else:
            step, twist = along, bend
        found.append(JointFrame(coordinate, prismatic, twist, theta, step + d * twist[:, 2], inertia))
        if standard:
            step, twist = along, bend
    return tuple(found)


def moved(pseudo_inertia: sp.Matrix, rotation: sp.Matrix, position: sp.Matrix) -> sp.Matrix:
    """The same body in another frame, in which its own frame has that rotation and position."""
    transform = rotation.row_join(position).col_join(sp.Matrix([[0, 0, 0, 1]]))
    return transform * pseudo_inertia * transform.T
