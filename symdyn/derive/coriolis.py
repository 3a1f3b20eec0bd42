"""The Coriolis matrix of the arm by composite bodies, every intermediate named (after Echeandia and Wensing 2021).

With T_p the pose of link p, dT_p/dt = T_p V_p, and E_j the unit twist of joint j as a 4 x 4 matrix, Lagrange's
equations in trace form have

    C_ij = sum over links p of tr(dT_p/dq_i J_p (d/dt dT_p/dq_j)^T),

which are the Christoffel symbols of the first kind times the velocities: M' - 2C is skew, and so is what a controller
needs. In the frame of joint j the sum over all links beyond it is one pseudo-inertia J and one relative flow K
(composite_bodies.py). With W_i = [V_i, E_i] the two halves of row and column j are, for i before j,

    C_ij = tr(E_i (J (V_j E_j)^T + K E_j^T)),    C_ji = tr(E_j J W_i^T) + tr(E_j (K + J V_j^T) E_i^T),

that is, three wrenches in frame j, which are handed inwards as in the mass matrix; the last one is a couple.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from symdyn.derive.composite_bodies import composite_bodies
from symdyn.derive.coriolis_terms import couple, link_twists, rate, swing, unit_twist, unit_wrench
from symdyn.derive.grouping import group
from symdyn.derive.newton_euler import joints_of
from symdyn.derive.pairs import Load, pairs
from symdyn.derive.screws import Joint, Z, power
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot


def coriolis_matrix(robot: Robot, steps: Steps) -> sp.Matrix:
    """C (n, n) of the rigid arm, with C qd the Coriolis and centripetal efforts; the intermediates go to ``steps``."""
    joints = joints_of(robot, steps)
    inertias = group([joint.frame for joint in joints], [joint.name for joint in robot.joints], steps)
    twists = link_twists(joints, _angular_velocities(joints, steps), 1, steps)
    bodies = composite_bodies(joints, inertias, 1, steps)
    axes = [(unit_twist(joint), rate(joint, twist)) for joint, twist in zip(joints, twists, strict=True)]
    loads = [
        Load((unit_wrench(body, joint), swing(body, joint, twist)), couple(body, joint, twist))
        for body, joint, twist in zip(bodies, joints, twists, strict=True)
    ]
    matrix = sp.zeros(len(joints), len(joints))
    for i, j, (unit, turning), load in pairs(joints, axes, loads, steps):
        matrix[i, j] = power(unit, load.wrenches[1])
        if i < j:
            matrix[j, i] = power(turning, load.wrenches[0]) + unit.omega.dot(load.couple)
    return matrix


def _angular_velocities(joints: Sequence[Joint], steps: Steps) -> list[sp.Matrix]:
    found, omega = [], sp.zeros(3, 1)
    for i, joint in enumerate(joints, start=1):
        law = f"{joint.label}: angular velocity"
        omega = joint.vector_outwards(f"omega_{i}", omega, law, steps)
        if not joint.frame.prismatic:
            omega = steps.vector(f"omega_{i}", omega + Z * joint.frame.coordinate.qd, law)
        found.append(omega)
    return found
