"""Frames on the joint axes, which the recursions use: z is the axis, whatever convention the robot is written in.

A link frame of the standard convention sits at the far end of its link. Seen from the near end, where the
joint is, standard and modified robots are the same: step and twist along x, then turn or slide along z.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

from symdyn.derive.bodies import bodies
from symdyn.derive.coordinates import Coordinate, joint_coordinates
from symdyn.derive.kinematics import fixed, rotation_x
from symdyn.derive.quantities import angle_expression, expression
from symdyn.spec.records import Convention, DHRow, JointKind, Placement, Robot


@dataclass(frozen=True, slots=True)
class Pose:
    """Of one frame in another: ``position`` (3,) of its origin, ``rotation`` (3, 3) from its axes to the other's."""

    position: sp.Matrix
    rotation: sp.Matrix


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


@lru_cache(maxsize=1)  # every recursion over one robot starts with them
def joint_frames(robot: Robot) -> tuple[JointFrame, ...]:
    """One frame per joint, from the base outwards; shared by all who ask, so their matrices are not written to."""
    link = Pose(sp.zeros(3, 1), sp.eye(3))  # of the link frame in the joint frame before
    found = []
    for joint, coordinate, own in zip(robot.joints, joint_coordinates(robot), bodies(robot), strict=True):
        prismatic = joint.kind is JointKind.PRISMATIC
        row = joint.placement
        before, after = _bends(row, robot.convention)
        step, twist = before.position, before.rotation
        angle = along = sp.Integer(0)
        if isinstance(row, DHRow):
            angle, along = angle_expression(row.theta), expression(row.d)
        if prismatic:
            along += coordinate.q
        else:
            angle += coordinate.q
        twist = link.rotation * twist
        position = link.position + link.rotation * step + along * twist[:, 2]
        inertia = moved(own.pseudo_inertia, after.rotation, after.position)
        found.append(JointFrame(coordinate, prismatic, twist, angle, position, inertia))
        link = after
    return tuple(found)


def tool_pose(robot: Robot) -> Pose:
    """The tool's frame in the last joint frame; the last link's own frame where there is no tool."""
    _, link = _bends(robot.joints[-1].placement, robot.convention)
    position, rotation = fixed(robot.tool.placement if robot.tool is not None else None)
    return Pose(link.position + link.rotation * position, link.rotation * rotation)


def _bends(row: DHRow | Placement, convention: Convention) -> tuple[Pose, Pose]:
    """What is fixed before the joint, and from the joint to its link's frame."""
    none = Pose(sp.zeros(3, 1), sp.eye(3))
    if isinstance(row, Placement):
        return Pose(*fixed(row)), none
    bend = Pose(sp.Matrix([expression(row.a), 0, 0]), rotation_x(angle_expression(row.alpha)))
    return (none, bend) if convention is Convention.STANDARD else (bend, none)


def moved(pseudo_inertia: sp.Matrix, rotation: sp.Matrix, position: sp.Matrix) -> sp.Matrix:
    """The same body in another frame, in which its own frame has that rotation and position."""
    transform = rotation.row_join(position).col_join(sp.Matrix([[0, 0, 0, 1]]))
    return transform * pseudo_inertia * transform.T
