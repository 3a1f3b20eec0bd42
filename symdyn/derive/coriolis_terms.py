"""What the velocities do to one joint's row and column: the wrenches of its composite body, in its frame.

Twists come times a number (``scale``), and so do the flow of a composite body and what is made of either here: it is
two where derivatives want 2 C, and the factor then costs nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from symdyn.derive.composite_bodies import CompositeBody
from symdyn.derive.screws import Joint, Twist, Wrench, Z
from symdyn.derive.steps import Steps


def link_twists(joints: Sequence[Joint], omegas: Sequence[sp.Matrix], scale: int, steps: Steps) -> tuple[Twist, ...]:
    """``scale`` times the twist of every link, in its frame, from their angular velocities."""
    found = []
    omega, velocity = sp.zeros(3, 1), sp.zeros(3, 1)
    for i, (joint, own) in enumerate(zip(joints, omegas, strict=True), start=1):
        law = f"{joint.label}: {'twice the ' if scale == 2 else ''}velocity of its frame"
        velocity = steps.vector(f"v_{i}b", velocity + omega.cross(scale * joint.frame.position), law)
        velocity = joint.vector_outwards(f"v_{i}", velocity, law, steps)
        if joint.frame.prismatic:
            velocity = steps.vector(f"v_{i}", velocity + Z * (scale * joint.frame.coordinate.qd), law)
        omega = own
        found.append(Twist(steps.vector(f"omega_{i}s", scale * omega, law), velocity))
    return tuple(found)


def unit_twist(joint: Joint) -> Twist:
    """E: of the link when its joint alone moves at unit speed."""
    none = sp.zeros(3, 1)
    return Twist(none, Z) if joint.frame.prismatic else Twist(Z, none)


def rate(joint: Joint, twist: Twist) -> Twist:
    """[V, E]: at which the unit twist changes with the motion of the link."""
    turning = twist.omega.cross(Z)
    if joint.frame.prismatic:
        return Twist(sp.zeros(3, 1), turning)
    return Twist(turning, twist.velocity.cross(Z))


def unit_wrench(body: CompositeBody, joint: Joint) -> Wrench:
    """E J: what accelerates the body by one along, or about, the axis."""
    s, h = body.second, body.first
    if joint.frame.prismatic:
        return Wrench(Z * body.mass, h.cross(Z))
    return Wrench(Z.cross(h), sp.Matrix([-s[0, 2], -s[1, 2], s[0, 0] + s[1, 1]]))


def swing(body: CompositeBody, joint: Joint, twist: Twist) -> Wrench:
    """J (V E)^T + K E^T: Coriolis forces on the body for unit speed of the joint."""
    s, h, k, w = body.second, body.first, body.flow, twist.omega
    if joint.frame.prismatic:
        velocity = w.cross(Z)
        return Wrench(body.mass * velocity, h.cross(velocity))
    force = sp.Matrix([-w[2] * h[0], -w[2] * h[1], w[0] * h[0] + w[1] * h[1]]) + Z.cross(body.momentum)
    return Wrench(
        force,
        sp.Matrix(
            [
                s[0, 1] * w[0] + s[1, 1] * w[1] + s[1, 2] * w[2] - k[2, 0],
                -s[0, 0] * w[0] - s[0, 1] * w[1] - s[0, 2] * w[2] - k[2, 1],
                k[0, 0] + k[1, 1],
            ]
        ),
    )


def couple(body: CompositeBody, joint: Joint, twist: Twist) -> sp.Matrix:
    """(3,), of E (K + J V^T): what the body's own flow does on an axis before."""
    s, h, k, w, v = body.second, body.first, body.flow, twist.omega, twist.velocity
    if joint.frame.prismatic:
        return (body.momentum + w.cross(h) + body.mass * v).cross(Z)
    return sp.Matrix(
        [
            s[0, 0] * w[1] - s[0, 1] * w[0] - h[0] * v[2] - k[0, 2],
            s[0, 1] * w[1] - s[1, 1] * w[0] - h[1] * v[2] - k[1, 2],
            s[0, 2] * w[1] - s[1, 2] * w[0] + h[0] * v[0] + h[1] * v[1] + k[0, 0] + k[1, 1],
        ]
    )
