"""Recursive Newton-Euler with named intermediates, for revolute and prismatic joints (seed 2.2.2).

Differences from the seed's print: the base ACCELERATION, not its velocity, is set against gravity;
moment and axis are taken in one frame; moments are about the frame's origin, so that a body enters
by its mass, first moment and inertia there.
"""

from __future__ import annotations

import sympy as sp

from symdyn.derive.bodies import Body, bodies
from symdyn.derive.kinematics import Frame, fixed, frames
from symdyn.derive.quantities import expression
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot


def _wrench(link: Body, omega: sp.Matrix, alpha: sp.Matrix, accel: sp.Matrix) -> tuple[sp.Matrix, sp.Matrix]:
    """Force and moment about the frame's origin that the motion of one body needs."""
    h, inertia = link.first_moment, link.inertia
    force = link.mass * accel + alpha.cross(h) + omega.cross(omega.cross(h))
    moment = inertia * alpha + omega.cross(inertia * omega) + h.cross(accel)
    return force, moment


def inverse_dynamics(robot: Robot, steps: Steps) -> tuple[sp.Expr, ...]:
    """Joint efforts of the rigid arm, one per joint; the intermediates go to ``steps``."""
    chain = frames(robot)
    names = [joint.name for joint in robot.joints]
    forces, moments, rotations = [], [], []

    omega = alpha = sp.zeros(3, 1)
    _, base = fixed(robot.base)
    accel = -base.T * sp.Matrix([expression(entry) for entry in robot.gravity])
    for i, (frame, link, name) in enumerate(zip(chain, bodies(robot), names, strict=True), start=1):
        omega, alpha, accel, rotation = _outward(frame, omega, alpha, accel, steps, i, f"link {i} ({name})")
        rotations.append(rotation)
        force, moment = _wrench(link, omega, alpha, accel)
        forces.append(steps.vector(f"F_{i}", force, f"link {i} ({name}): Newton, inertial force"))
        moments.append(steps.vector(f"N_{i}", moment, f"link {i} ({name}): Euler, inertial moment"))

    efforts: list[sp.Expr] = []
    force = moment = sp.zeros(3, 1)  # of the next link on this one, about this frame's origin
    for i in range(len(chain), 0, -1):
        frame, name = chain[i - 1], names[i - 1]
        force = steps.vector(f"f_{i}", forces[i - 1] + force, f"link {i} ({name}): force from link {i - 1}")
        moment = moments[i - 1] + moment + frame.after.cross(force)
        moment = steps.vector(f"n_{i}", moment, f"link {i} ({name}): moment from link {i - 1}")
        efforts.append(frame.axis.dot(force if frame.prismatic else moment))
        force_before = rotations[i - 1] * force
        force_before = steps.vector(f"fb_{i}", force_before, f"link {i} ({name}): force, in frame {i - 1}")
        moment = rotations[i - 1] * moment + frame.before.cross(force_before)
        force = force_before
    return tuple(reversed(efforts))


def _outward(
    frame: Frame, omega: sp.Matrix, alpha: sp.Matrix, accel: sp.Matrix, steps: Steps, i: int, origin: str
) -> tuple[sp.Matrix, sp.Matrix, sp.Matrix, sp.Matrix]:
    """Angular velocity, angular acceleration, acceleration of the origin of frame i, in frame i."""
    c = frame.coordinate
    rotation = name_matrix(f"R_{i}", frame.rotation, f"{origin}: rotation", steps)
    carried = rotation.T * (accel + alpha.cross(frame.before) + omega.cross(omega.cross(frame.before)))
    turned = rotation.T * omega
    if frame.prismatic:
        omega_i = turned
        alpha_i = rotation.T * alpha
    else:
        turned = steps.vector(f"omega_{i}r", turned, f"{origin}: angular velocity of link {i - 1}")
        omega_i = turned + frame.axis * c.qd
        alpha_i = rotation.T * alpha + frame.axis * c.qdd + turned.cross(frame.axis * c.qd)
    omega_i = steps.vector(f"omega_{i}", omega_i, f"{origin}: angular velocity")
    alpha_i = steps.vector(f"alpha_{i}", alpha_i, f"{origin}: angular acceleration")
    accel_i = carried + alpha_i.cross(frame.after) + omega_i.cross(omega_i.cross(frame.after))
    if frame.prismatic:
        accel_i += frame.axis * c.qdd + 2 * omega_i.cross(frame.axis * c.qd)
    return omega_i, alpha_i, steps.vector(f"a_{i}", accel_i, f"{origin}: acceleration of its frame"), rotation


def name_matrix(name: str, matrix: sp.Matrix, origin: str, steps: Steps) -> sp.Matrix:
    """The matrix with its entries named, so that each product of sines and cosines is formed once."""
    return sp.Matrix(3, 3, lambda r, k: steps.name(f"{name}_{r + 1}{k + 1}", matrix[r, k], origin))
