"""Derivatives of the arm's inverse dynamics by composite bodies, every intermediate named.

Notation of coriolis.py; with A_p = T_p^-1 d2T_p/dt2, gravity being an acceleration of the base, inverse dynamics is

    tau_i = sum over links p from i on of tr(dT_p/dq_i J_p (T_p A_p)^T).

Moving joint j turns all that is beyond it as one body, and changes its motion as the joint's unit twist changes along
that motion: with X_j = T_j E_j T_j^-1, in the world's axes, T_p becomes X_j T_p, and its second derivative gains
(d2X_j/dt2) T_p + 2 (dX_j/dt) dT_p/dt. With P_j, the sum of J_p A_p^T from j on, which is the wrench through joint j,
and with J, K, V_j of the composite body, all in frame j,

    dtau_i/dq_j = tr(E_i (E_j P_j + P_j E_j^T + J [A_j, E_j]^T + 2 K [V_j, E_j]^T)),      i up to j,
    dtau_j/dq_i = tr(E_j J B_i^T) + 2 tr(E_j (K + J V_j^T) [V_i, E_i]^T),                 i before j,

where B_i = T_i^-1 (d2X_i/dt2) T_i is a twist again. With respect to speeds the derivative is 2 C. These are the
derivatives of Carpentier and Mansard (2018), in the order of computation of Singh, Russell and Wensing (2022), written
for pseudo-inertias and velocities relative to the joint, which are cheaper.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from symdyn.derive.composite import holding_efforts
from symdyn.derive.composite_bodies import CompositeBody, composite_bodies
from symdyn.derive.coriolis_terms import couple, link_twists, rate, swing, unit_twist, unit_wrench
from symdyn.derive.grouping import group
from symdyn.derive.newton_euler import Motion, joints_of, recursion
from symdyn.derive.pairs import Load, pairs
from symdyn.derive.screws import Joint, Twist, Wrench, Z, power
from symdyn.derive.steps import Step, Steps
from symdyn.spec.records import Robot


@dataclass(frozen=True, slots=True)
class EffortJacobian:
    """Derivatives (n, n) of the arm's efforts, and their share (n,) at rest, in symbols of ``steps``.

    ``by_speed``, ``by_acceleration``, which is the mass matrix, and ``gravity`` do not depend on accelerations, so that
    forward dynamics follows from them: the efforts are by_acceleration qdd + by_speed qd / 2 + gravity.
    """

    steps: tuple[Step, ...]
    by_position: sp.Matrix
    by_speed: sp.Matrix
    by_acceleration: sp.Matrix
    gravity: tuple[sp.Expr, ...]


def effort_jacobian(robot: Robot) -> EffortJacobian:
    """Of the rigid arm, one row per joint."""
    steps = Steps()
    joints, n = joints_of(robot, steps), len(robot.joints)
    inertias = group([joint.frame for joint in joints], [joint.name for joint in robot.joints], steps)
    arm = recursion(robot, joints, inertias, steps)
    twists = link_twists(joints, [motion.omega for motion in arm.motions], 2, steps)
    bodies = composite_bodies(joints, inertias, 2, steps)
    axes, loads = [], []
    for k, (joint, motion, twist, body) in enumerate(zip(joints, arm.motions, twists, bodies, strict=True), start=1):
        turning = Twist(sp.zeros(3, 1) if joint.frame.prismatic else motion.omega.cross(Z), sp.zeros(3, 1))
        axes.append((unit_twist(joint), rate(joint, twist), _second(joint, motion, twist, steps, k), turning))
        law = f"{joint.label}: Coriolis terms"
        swung = _named(f"C_{k}", swing(body, joint, twist), law, steps)
        flow = steps.vector(f"C_{k}_c", couple(body, joint, twist), law)
        pushed = _push(body, joint, motion, turning.omega, arm.wrenches[k - 1], steps, k)
        loads.append(Load((unit_wrench(body, joint), swung, pushed), flow))
    by_position, by_speed, mass = sp.zeros(n, n), sp.zeros(n, n), sp.zeros(n, n)
    for i, j, (unit, changing, second, turning), load in pairs(joints, axes, loads, steps):
        accelerated, swung, pushed = load.wrenches
        mass[i, j] = mass[j, i] = power(unit, accelerated)
        by_speed[i, j] = power(unit, swung)
        by_position[i, j] = power(unit, pushed)
        if i < j:
            by_speed[j, i] = power(changing, accelerated) + unit.omega.dot(load.couple)
            by_position[j, i] = power(second, accelerated) + turning.omega.dot(load.couple)
    gravity = holding_efforts(robot, joints, bodies, steps)
    return EffortJacobian(steps.freeze(), by_position, by_speed, mass, gravity)


def _named(name: str, wrench: Wrench, law: str, steps: Steps) -> Wrench:
    return Wrench(steps.vector(f"{name}_f", wrench.force, law), steps.vector(f"{name}_n", wrench.moment, law))


def _second(joint: Joint, motion: Motion, twist: Twist, steps: Steps, j: int) -> Twist:
    """B: at which the unit twist changes, twice, with the motion of the link; ``twist`` is twice its twist."""
    along = motion.field[:, 2]
    if joint.frame.prismatic:
        return Twist(sp.zeros(3, 1), along)
    w, a, v = motion.omega, motion.accel, twist.velocity
    velocity = sp.Matrix([a[1] + v[2] * w[0], v[2] * w[1] - a[0], -v[0] * w[0] - v[1] * w[1]])
    return Twist(along, steps.vector(f"B_{j}", velocity, f"{joint.label}: second change of its axis"))


def _push(
    body: CompositeBody, joint: Joint, motion: Motion, turning: sp.Matrix, through: Wrench, steps: Steps, j: int
) -> Wrench:
    """E P + P E^T + J [A, E]^T + 2 K [V, E]^T: what a small turn of the joint changes in the wrench through it."""
    law = f"{joint.label}: change with its position"
    s, h, k, u, a = body.second, body.first, body.flow, motion.field, motion.accel
    if joint.frame.prismatic:
        along = u[:, 2]
        return _named(f"P_{j}", Wrench(body.mass * along, h.cross(along) + Z.cross(through.force)), law, steps)
    g0 = steps.name(f"G_{j}_0", 2 * motion.product_xy, law)
    g1 = steps.name(f"G_{j}_1", u[1, 1] - u[0, 0], law)
    commutator = sp.Matrix([[g0, g1, u[1, 2]], [g1, -g0, -u[0, 2]], [u[2, 1], -u[2, 0], 0]])
    across = sp.Matrix([a[1], -a[0], 0])
    force = commutator * h + body.mass * across + turning.cross(body.momentum) + Z.cross(through.force)
    moment = sp.Matrix(
        [
            s[0, 1] * u[2, 1] - s[1, 1] * u[2, 0] - s[0, 2] * g1 + s[1, 2] * g0 + s[2, 2] * u[0, 2],
            s[0, 2] * g0 + s[1, 2] * g1 + s[2, 2] * u[1, 2] - s[0, 0] * u[2, 1] + s[0, 1] * u[2, 0],
            (s[0, 0] - s[1, 1]) * g1 - 2 * s[0, 1] * g0 - s[0, 2] * u[0, 2] - s[1, 2] * u[1, 2],
        ]
    )
    x, y = turning[0], turning[1]
    flow = sp.Matrix(
        [
            (k[1, 1] + k[2, 2]) * x - k[1, 0] * y,
            (k[0, 0] + k[2, 2]) * y - k[0, 1] * x,
            -k[0, 2] * x - k[1, 2] * y,
        ]
    )
    moment += h.cross(across) + flow + Z.cross(through.moment)
    return _named(f"P_{j}", Wrench(force, moment), law, steps)
