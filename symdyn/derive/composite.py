"""What follows from composite bodies alone, every intermediate named: the mass matrix (Walker and Orin 1982), gravity.

With all joints but one locked, the links beyond it move as one body: the effort at each joint when joint j alone is
accelerated by one is column j of M. At rest the same body hangs on its joint.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from symdyn.derive.composite_bodies import CompositeBody, composite_bodies
from symdyn.derive.coriolis_terms import unit_twist, unit_wrench
from symdyn.derive.grouping import group
from symdyn.derive.newton_euler import base_acceleration, joints_of
from symdyn.derive.pairs import Load, pairs
from symdyn.derive.screws import Joint, power
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot


def mass_matrix(robot: Robot, steps: Steps) -> sp.Matrix:
    """(n, n) of the rigid arm, symmetric; the intermediates go to ``steps``."""
    joints, bodies = _at_rest(robot, steps)
    axes = [(unit_twist(joint),) for joint in joints]
    loads = [Load((unit_wrench(body, joint),), sp.zeros(3, 1)) for body, joint in zip(bodies, joints, strict=True)]
    matrix = sp.zeros(len(joints), len(joints))
    for i, j, (unit,), load in pairs(joints, axes, loads, steps):
        matrix[i, j] = matrix[j, i] = power(unit, load.wrenches[0])
    return matrix


def gravity(robot: Robot, steps: Steps) -> tuple[sp.Expr, ...]:
    """Effort of each joint that holds the rigid arm; the intermediates go to ``steps``."""
    return holding_efforts(robot, *_at_rest(robot, steps), steps)


def holding_efforts(
    robot: Robot, joints: Sequence[Joint], bodies: Sequence[CompositeBody], steps: Steps
) -> tuple[sp.Expr, ...]:
    """The same, from the composite bodies."""
    upwards, efforts = base_acceleration(robot), []
    for i, (joint, body) in enumerate(zip(joints, bodies, strict=True), start=1):
        upwards = joint.vector_outwards(f"g_{i}", upwards, f"{joint.label}: gravity", steps)
        moment = body.first[0] * upwards[1] - body.first[1] * upwards[0]
        efforts.append(body.mass * upwards[2] if joint.frame.prismatic else moment)
    return tuple(efforts)


def _at_rest(robot: Robot, steps: Steps) -> tuple[tuple[Joint, ...], tuple[CompositeBody, ...]]:
    joints = joints_of(robot, steps)
    inertias = group([joint.frame for joint in joints], [joint.name for joint in robot.joints], steps)
    return joints, composite_bodies(joints, inertias, 0, steps)
