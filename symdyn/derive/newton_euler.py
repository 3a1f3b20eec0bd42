"""Recursive Newton-Euler inverse dynamics with every intermediate named (Luh, Walker, Paul 1980).

Frames stand on the joint axes, and a body enters by its pseudo-inertia there: mass m, first moment h,
second moment S. With the matrix U = [alpha]x + [omega]x^2, which gives the acceleration U r of a point r
relative to the origin (Khalil and Kleinfinger 1987), the laws of Newton and Euler are

    F = m a + U h,        N = h x a + the axial vector of U S - S U^T.

The second is the trace form of Lagrange's equations, read for one body; it needs no products of
angular velocities but those in U.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from symdyn.derive.grouping import group
from symdyn.derive.joint_frames import JointFrame, joint_frames
from symdyn.derive.kinematics import fixed
from symdyn.derive.quantities import expression
from symdyn.derive.screws import Joint, Wrench
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot


def inverse_dynamics(robot: Robot, steps: Steps, grouped: bool = True) -> tuple[sp.Expr, ...]:
    """Joint efforts of the rigid arm, one per joint; the intermediates go to ``steps``.

    ``grouped``: with base inertial parameters, which are fewer, in place of those of each link.
    """
    chain, names = joint_frames(robot), [joint.name for joint in robot.joints]
    inertias = group(chain, names, steps) if grouped else tuple(frame.pseudo_inertia for frame in chain)
    return efforts(robot, inertias, steps)


def efforts(robot: Robot, inertias: Sequence[sp.Matrix], steps: Steps) -> tuple[sp.Expr, ...]:
    """The same with any pseudo-inertias (4, 4) of the links in place of their own."""
    joints = joints_of(robot, steps)
    wrenches = recursion(robot, joints, inertias, steps).wrenches
    return tuple(w.force[2] if j.frame.prismatic else w.moment[2] for j, w in zip(joints, wrenches, strict=True))


def joints_of(robot: Robot, steps: Steps) -> tuple[Joint, ...]:
    """The joints with their rotations, whose sines and cosines are named."""
    chain, names = joint_frames(robot), [joint.name for joint in robot.joints]
    return tuple(
        Joint(frame, turn, f"link {i} ({name})")
        for i, (frame, turn, name) in enumerate(zip(chain, turns(chain, names, steps), names, strict=True), start=1)
    )


def turns(chain: Sequence[JointFrame], names: Sequence[str], steps: Steps) -> tuple[sp.Matrix, ...]:
    """The rotation about z by each joint's angle, sines and cosines named."""
    found = []
    for i, (frame, name) in enumerate(zip(chain, names, strict=True), start=1):
        law = f"link {i} ({name}): rotation"
        c, s = steps.name(f"c_{i}", sp.cos(frame.angle), law), steps.name(f"s_{i}", sp.sin(frame.angle), law)
        found.append(sp.Matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]]))
    return tuple(found)


def base_acceleration(robot: Robot) -> sp.Matrix:
    """(3,) that stands for gravity: of the base upwards, in its axes."""
    _, base = fixed(robot.base)
    return -base.T * sp.Matrix([expression(entry) for entry in robot.gravity])


@dataclass(frozen=True, slots=True)
class Motion:
    """Of a frame, in that frame: angular velocity, angular acceleration, U, acceleration of the origin."""

    omega: sp.Matrix
    alpha: sp.Matrix
    product_xy: sp.Expr  # omega_x omega_y
    field: sp.Matrix
    accel: sp.Matrix


@dataclass(frozen=True, slots=True)
class Recursion:
    """Of every link, in its frame: how it moves, and the ``wrench`` through its joint."""

    motions: tuple[Motion, ...]
    wrenches: tuple[Wrench, ...]


def recursion(robot: Robot, joints: Sequence[Joint], inertias: Sequence[sp.Matrix], steps: Steps) -> Recursion:
    """Outwards and back, with pseudo-inertias (4, 4) of the links."""
    motion = Motion(sp.zeros(3, 1), sp.zeros(3, 1), sp.Integer(0), sp.zeros(3, 3), base_acceleration(robot))
    motions, own = [], []
    for i, (joint, inertia) in enumerate(zip(joints, inertias, strict=True), start=1):
        motion = _outward(joint, motion, steps, i)
        motions.append(motion)
        own.append(_wrench(inertia, motion, steps, i, joint.label))
    return Recursion(tuple(motions), _inward(joints, own, steps))


def _outward(joint: Joint, before: Motion, steps: Steps, i: int) -> Motion:
    frame, origin = joint.frame, joint.label
    c, z = frame.coordinate, sp.Matrix([0, 0, 1])

    def carried(name: str, vector: sp.Matrix, law: str) -> sp.Matrix:
        return joint.vector_outwards(f"{name}_{i}", vector, f"{origin}: {law}", steps)

    omega = carried("omega", before.omega, f"angular velocity of link {i - 1}")
    # Along its own axis the joint changes nothing: the last column of U is that of the link before, turned.
    column = carried("U", before.field * frame.axis, "acceleration field U along the axis")
    moved = before.accel + before.field * frame.position
    accel = carried("a", steps.vector(f"a_{i}b", moved, f"{origin}: acceleration of its joint"), "acceleration")
    spin = frame.axis.dot(before.alpha)
    if frame.prismatic:
        accel = accel + z * c.qdd + 2 * omega.cross(z * c.qd)
        accel = steps.vector(f"a_{i}", accel, f"{origin}: acceleration of its frame")
    else:
        omega = steps.vector(f"omega_{i}", omega + z * c.qd, f"{origin}: angular velocity")
        spin = spin + c.qdd
    return Motion(omega, *_field(omega, column, spin, steps, i, origin), accel)


def _field(
    omega: sp.Matrix, column: sp.Matrix, spin: sp.Expr, steps: Steps, i: int, origin: str
) -> tuple[sp.Matrix, sp.Expr, sp.Matrix]:
    """Angular acceleration, w_xy, and U = [alpha]x + [omega]x^2, from the last column of U and ``spin``, alpha_z.

    With w_rk = omega_r omega_k: alpha_y = U_xz - w_xz, and U_zx = w_xz - alpha_y, which is U_xz
    mirrored; likewise for x. On the diagonal, U_zz = -(w_xx + w_yy) saves one square.
    """
    law = f"{origin}: products of angular velocity"

    def product(r: int, k: int) -> sp.Expr:
        return steps.name(f"w_{i}_{'xyz'[r]}{'xyz'[k]}", omega[r] * omega[k], law)

    w_xy, w_xz, w_yz, w_xx, w_zz = product(0, 1), product(0, 2), product(1, 2), product(0, 0), product(2, 2)
    alpha = sp.Matrix([w_yz - column[1], column[0] - w_xz, spin])
    alpha = steps.vector(f"alpha_{i}", alpha, f"{origin}: angular acceleration")
    field = sp.Matrix(
        [
            [column[2] + w_xx - w_zz, w_xy - alpha[2], column[0]],
            [w_xy + alpha[2], -w_xx - w_zz, column[1]],
            [w_xz - alpha[1], w_yz + alpha[0], column[2]],
        ]
    )
    law = f"{origin}: acceleration field U"
    return alpha, w_xy, sp.Matrix(3, 3, lambda r, k: steps.name(f"U_{i}_{'xyz'[r]}{'xyz'[k]}", field[r, k], law))


def _wrench(inertia: sp.Matrix, motion: Motion, steps: Steps, i: int, origin: str) -> Wrench:
    """About the frame's origin, what the motion of one body needs."""
    second, first, mass = inertia[:3, :3], inertia[:3, 3], inertia[3, 3]
    u = motion.field
    force = mass * motion.accel + u * first
    x = u[2, 0] * second[0, 1] + u[2, 1] * second[1, 1] - u[1, 0] * second[0, 2] - u[1, 2] * second[2, 2]
    y = u[0, 1] * second[1, 2] + u[0, 2] * second[2, 2] - u[2, 0] * second[0, 0] - u[2, 1] * second[0, 1]
    z = u[1, 2] * second[0, 2] - u[0, 2] * second[1, 2]
    # U_yx and U_xy are the sum and difference of w_xy and alpha_z, which are at hand.
    z += (second[0, 0] + second[1, 1]) * motion.alpha[2] + (second[0, 0] - second[1, 1]) * motion.product_xy
    x += (u[2, 2] - u[1, 1]) * second[1, 2]
    y += (u[0, 0] - u[2, 2]) * second[0, 2]
    z += (u[1, 1] - u[0, 0]) * second[0, 1]
    moment = sp.Matrix([x, y, z]) + first.cross(motion.accel)
    return Wrench(
        steps.vector(f"F_{i}", force, f"{origin}: Newton, inertial force"),
        steps.vector(f"N_{i}", moment, f"{origin}: Euler, inertial moment"),
    )


def _inward(joints: Sequence[Joint], own: Sequence[Wrench], steps: Steps) -> tuple[Wrench, ...]:
    found = []
    force = moment = sp.zeros(3, 1)  # of link i+1 on link i, in frame i
    for i in range(len(joints), 0, -1):
        frame, turn, law = joints[i - 1].frame, joints[i - 1].turn, joints[i - 1].label
        force = steps.vector(f"f_{i}", own[i - 1].force + force, f"{law}: force from link {i - 1}")
        moment = steps.vector(f"n_{i}", own[i - 1].moment + moment, f"{law}: moment from link {i - 1}")
        found.append(Wrench(force, moment))
        force = steps.vector(f"f_{i}t", turn * force, f"{law}: force, before its turn")
        force = steps.vector(f"f_{i}b", frame.twist * force, f"{law}: force, in frame {i - 1}")
        moment = steps.vector(f"n_{i}t", turn * moment, f"{law}: moment, before its turn")
        moment = frame.twist * moment + frame.position.cross(force)
        moment = steps.vector(f"n_{i}b", moment, f"{law}: moment, in frame {i - 1}")
    return tuple(reversed(found))
