"""All links from one joint outwards as one body: its pseudo-inertia, and how its links move against each other.

With T_p the pose of link p and dT_p/dt = T_p V_p, the inertia of the links beyond joint j is the sum of their
pseudo-inertias J_p, in the frame of j, and the flow of their moments is K_j, the sum of J_p (V_p - V_j)^T. From one
frame to that before, the composite body gains only what its own joint does:

    K_i = K_j + J_j E_j^T qd_j,    j = i + 1, E_j the unit twist of joint j,

so that K needs no velocity but those of the joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from symdyn.derive.screws import Joint, Z, skew
from symdyn.derive.steps import Steps


@dataclass(frozen=True, slots=True)
class CompositeBody:
    """Of the links from j on, in frame j: second moments (3, 3), first moments (3,) and mass; ``flow`` (3, 3) and
    ``momentum`` (3,) are the upper rows and the last one of the relative K, times a number."""

    second: sp.Matrix
    first: sp.Matrix
    mass: sp.Expr
    flow: sp.Matrix
    momentum: sp.Matrix


def composite_bodies(
    joints: Sequence[Joint], inertias: Sequence[sp.Matrix], scale: int, steps: Steps
) -> tuple[CompositeBody, ...]:
    """One per joint; K is ``scale`` times as large as it is, and left out with zero."""
    found = []
    beyond = CompositeBody(sp.zeros(3, 3), sp.zeros(3, 1), sp.Integer(0), sp.zeros(3, 3), sp.zeros(3, 1))
    for j in range(len(joints), 0, -1):
        inertia, law = inertias[j - 1], f"{joints[j - 1].label}: composite body"
        body = CompositeBody(
            _symmetric(f"S_{j}", inertia[:3, :3] + beyond.second, law, steps),
            steps.vector(f"h_{j}", inertia[:3, 3] + beyond.first, law),
            steps.name(f"m_{j}", inertia[3, 3] + beyond.mass, law),
            steps.matrix(f"K_{j}", beyond.flow, f"{law}: flow of its moments"),
            steps.vector(f"l_{j}", beyond.momentum, f"{law}: momentum"),
        )
        found.append(body)
        if j > 1:
            beyond = _seen_before(_with_its_joint(body, joints[j - 1], scale), joints[j - 1], j, steps)
    return tuple(reversed(found))


def _with_its_joint(body: CompositeBody, joint: Joint, scale: int) -> CompositeBody:
    """Moving against the link before, not against its own first link."""
    speed = scale * joint.frame.coordinate.qd
    if joint.frame.prismatic:
        flow, momentum = body.first * Z.T * speed, body.mass * Z * speed
    else:
        flow, momentum = body.second * skew(Z * speed).T, speed * Z.cross(body.first)
    return CompositeBody(body.second, body.first, body.mass, body.flow + flow, body.momentum + momentum)


def _seen_before(body: CompositeBody, joint: Joint, j: int, steps: Steps) -> CompositeBody:
    """The composite body in the frame before."""
    law, turn = f"{joint.label}: composite body, before its turn", joint.turn
    c, s = turn[0, 0], turn[1, 0]
    squared, both = steps.name(f"ss_{j}", s * s, law), steps.name(f"sc_{j}", s * c, law)

    def across(name: str, matrix: sp.Matrix) -> sp.Matrix:
        """turn * matrix * turn^T; in the plane the difference of the squares and the sum of the products turn."""
        difference = steps.name(f"{name}_d", matrix[0, 0] - matrix[1, 1], law)
        products = steps.name(f"{name}_p", matrix[0, 1] + matrix[1, 0], law)
        squares = steps.name(f"{name}_a", squared * difference + both * products, law)
        mixed = steps.name(f"{name}_b", both * difference - squared * products, law)
        column, row = turn[:2, :2] * matrix[:2, 2], turn[:2, :2] * matrix[2, :2].T
        return sp.Matrix(
            [
                [matrix[0, 0] - squares, matrix[0, 1] + mixed, column[0]],
                [matrix[1, 0] + mixed, matrix[1, 1] + squares, column[1]],
                [row[0], row[1], matrix[2, 2]],
            ]
        )

    twist, p = joint.frame.twist, joint.frame.position
    second = _symmetric(f"S_{j}t", across(f"S_{j}", body.second), law, steps)
    second = _symmetric(f"S_{j}r", twist * second * twist.T, law, steps)
    first = joint.vector_inwards(f"h_{j}t", body.first, law, steps)
    own = steps.matrix(f"K_{j}o", body.flow, law)
    flow = steps.matrix(f"K_{j}t", across(f"K_{j}", own), law)
    flow = steps.matrix(f"K_{j}r", twist * flow * twist.T, law)
    momentum = steps.vector(f"l_{j}o", body.momentum, law)
    momentum = joint.vector_inwards(f"l_{j}t", momentum, law, steps)
    moved = steps.vector(f"h_{j}b", first + body.mass * p, law)
    return CompositeBody(second + p * moved.T + first * p.T, moved, body.mass, flow + p * momentum.T, momentum)


def _symmetric(name: str, matrix: sp.Matrix, origin: str, steps: Steps) -> sp.Matrix:
    named = sp.zeros(3, 3)
    for r in range(3):
        for c in range(r, 3):
            named[r, c] = named[c, r] = steps.name(f"{name}_{r + 1}{c + 1}", matrix[r, c], origin)
    return named
