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
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot


def inverse_dynamics(robot: Robot, steps: Steps, grouped: bool = True) -> tuple[sp.Expr, ...]:
    """Joint efforts of the rigid arm, one per joint; the intermediates go to ``steps``.

    ``grouped``: with base inertial parameters, which are fewer, in place of those of each link.
    """
    chain, names = joint_frames(robot), [joint.name for joint in robot.joints]
    inertias = group(chain, names, steps) if grouped else tuple(frame.pseudo_inertia for frame in chain)
    return efforts(robot, chain, inertias, steps)


def efforts(
    robot: Robot, chain: Sequence[JointFrame], inertias: Sequence[sp.Matrix], steps: Steps
) -> tuple[sp.Expr, ...]:
    """The same with any pseudo-inertias (4, 4) of the links in place of their own."""
    names = [joint.name for joint in robot.joints]
    _, base = fixed(robot.base)
    gravity = base.T * sp.Matrix([expression(entry) for entry in robot.gravity])
    motion = _Motion(sp.zeros(3, 1), sp.zeros(3, 1), sp.Integer(0), sp.zeros(3, 3), -gravity)
    turned, wrenches = turns(chain, names, steps), []
    for i, (frame, inertia, name) in enumerate(zip(chain, inertias, names, strict=True), start=1):
        origin = f"link {i} ({name})"
        motion = _outward(frame, turned[i - 1], motion, steps, i, origin)
        wrenches.append(_wrench(inertia, motion, steps, i, origin))
    return _inward(chain, turned, wrenches, names, steps)


def turns(chain: Sequence[JointFrame], names: Sequence[str], steps: Steps) -> tuple[sp.Matrix, ...]:
    """The rotation about z by each joint's angle, sines and cosines named."""
    found = []
    for i, (frame, name) in enumerate(zip(chain, names, strict=True), start=1):
        law = f"link {i} ({name}): rotation"
        c, s = steps.name(f"c_{i}", sp.cos(frame.angle), law), steps.name(f"s_{i}", sp.sin(frame.angle), law)
        found.append(sp.Matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]]))
    return tuple(found)


@dataclass(frozen=True, slots=True)
class _Motion:
    """Of a frame, in that frame: angular velocity, angular acceleration, U, acceleration of the origin."""

    omega: sp.Matrix
    alpha: sp.Matrix
    product_xy: sp.Expr  # omega_x omega_y
    field: sp.Matrix
    accel: sp.Matrix


def _outward(frame: JointFrame, turn: sp.Matrix, before: _Motion, steps: Steps, i: int, origin: str) -> _Motion:
    c, z = frame.coordinate, sp.Matrix([0, 0, 1])

    def carried(name: str, vector: sp.Matrix, law: str) -> sp.Matrix:
        twisted = steps.vector(f"{name}_{i}t", frame.twist.T * vector, f"{origin}: {law}")
        return steps.vector(f"{name}_{i}r", turn.T * twisted, f"{origin}: {law}")

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
    return _Motion(omega, *_field(omega, column, spin, steps, i, origin), accel)


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


def _wrench(inertia: sp.Matrix, motion: _Motion, steps: Steps, i: int, origin: str) -> tuple[sp.Matrix, sp.Matrix]:
    """Force and moment about the frame's origin that the motion of one body needs."""
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
    return (
        steps.vector(f"F_{i}", force, f"{origin}: Newton, inertial force"),
        steps.vector(f"N_{i}", moment, f"{origin}: Euler, inertial moment"),
    )


def _inward(
    chain: Sequence[JointFrame],
    turned: Sequence[sp.Matrix],
    wrenches: Sequence[tuple[sp.Matrix, sp.Matrix]],
    names: Sequence[str],
    steps: Steps,
) -> tuple[sp.Expr, ...]:
    found: list[sp.Expr] = []
    force = moment = sp.zeros(3, 1)  # of link i+1 on link i, in frame i
    for i in range(len(chain), 0, -1):
        frame, law = chain[i - 1], f"link {i} ({names[i - 1]})"
        force = steps.vector(f"f_{i}", wrenches[i - 1][0] + force, f"{law}: force from link {i - 1}")
        moment = steps.vector(f"n_{i}", wrenches[i - 1][1] + moment, f"{law}: moment from link {i - 1}")
        found.append(force[2] if frame.prismatic else moment[2])
        force = steps.vector(f"f_{i}t", turned[i - 1] * force, f"{law}: force, before its turn")
        force = steps.vector(f"f_{i}b", frame.twist * force, f"{law}: force, in frame {i - 1}")
        moment = steps.vector(f"n_{i}t", turned[i - 1] * moment, f"{law}: moment, before its turn")
        moment = frame.twist * moment + frame.position.cross(force)
        moment = steps.vector(f"n_{i}b", moment, f"{law}: moment, in frame {i - 1}")
    return tuple(reversed(found))
