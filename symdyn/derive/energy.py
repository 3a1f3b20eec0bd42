"""Kinetic and potential energy of the arm, by velocity recursion with named intermediates."""

from __future__ import annotations

import sympy as sp

from symdyn.derive.bodies import bodies
from symdyn.derive.kinematics import fixed, frames
from symdyn.derive.quantities import expression
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot


def energies(robot: Robot, steps: Steps) -> tuple[sp.Expr, sp.Expr]:
    """(kinetic, potential) energy of the links; the potential is zero at the origin of the world frame."""
    gravity = sp.Matrix([expression(entry) for entry in robot.gravity])
    omega = velocity = sp.zeros(3, 1)
    origin, orientation = fixed(robot.base)
    kinetic = potential = sp.Integer(0)
    chain = zip(frames(robot), bodies(robot), robot.joints, strict=True)
    for i, (frame, link, joint) in enumerate(chain, start=1):
        c, label = frame.coordinate, f"link {i} ({joint.name})"
        rotation = steps.matrix(f"R_{i}", frame.rotation, f"{label}: rotation")
        velocity = rotation.T * (velocity + omega.cross(frame.before))
        omega = rotation.T * omega
        if frame.prismatic:
            velocity += frame.axis * c.qd
        else:
            omega += frame.axis * c.qd
        omega = steps.vector(f"omega_{i}", omega, f"{label}: angular velocity")
        velocity = steps.vector(f"v_{i}", velocity + omega.cross(frame.after), f"{label}: velocity of its frame")
        kinetic += link.mass * velocity.dot(velocity) / 2
        kinetic += velocity.dot(omega.cross(link.first_moment)) + omega.dot(link.inertia * omega) / 2
        origin = steps.vector(
            f"x_{i}", origin + orientation * (frame.before + rotation * frame.after), f"{label}: its origin"
        )
        orientation = steps.matrix(f"Q_{i}", orientation * rotation, f"{label}: orientation")
        potential -= gravity.dot(link.mass * origin + orientation * link.first_moment)
    return kinetic, potential
