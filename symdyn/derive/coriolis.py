"""The Coriolis matrix of the arm by composite bodies, every intermediate named (after Echeandia and Wensing 2021).

With T_p the pose of link p, V_p its velocity as a 4 x 4 matrix, and E_j that of a unit speed of joint j, Lagrange's
equations in trace form have

    C_ij = sum over links p of tr(dT_p/dq_i J_p (d/dt dT_p/dq_j)^T),

which are the Christoffel symbols of the first kind times the velocities: M' - 2C is skew, and so is what a controller
needs. In the frame of joint j the sum over all links beyond it is one pseudo-inertia J and one matrix K, the sum of
J_p V_p^T; with W = [V_j, E_j] the two halves of row and column j are, for i before j,

    C_ij = tr(E_i (J W_j^T + K E_j^T)),        C_ji = tr(W_i E_j J) + tr(E_j K E_i^T),

that is, three wrenches in frame j, which are handed inwards as in the mass matrix; the last one is a couple.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from symdyn.derive.grouping import group
from symdyn.derive.joint_frames import JointFrame, joint_frames
from symdyn.derive.newton_euler import turns
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot

_Z = sp.ImmutableMatrix([0, 0, 1])


@dataclass(frozen=True, slots=True)
class _Twist:
    """Angular velocity, and velocity of the frame's origin, in the frame."""

    omega: sp.Matrix
    velocity: sp.Matrix


@dataclass(frozen=True, slots=True)
class _Composite:
    """Of all links from one on: J by its second moments S (3, 3), first moments h (3,) and mass; K = sum of J V^T by
    its upper rows (3, 3) and its last one, which is the momentum (3,)."""

    second: sp.Matrix
    first: sp.Matrix
    mass: sp.Expr
    flow: sp.Matrix
    momentum: sp.Matrix


_NOTHING = _Composite(sp.zeros(3, 3), sp.zeros(3, 1), sp.Integer(0), sp.zeros(3, 3), sp.zeros(3, 1))


def coriolis_matrix(robot: Robot, steps: Steps) -> sp.Matrix:
    """C (n, n) of the rigid arm, with C qd the Coriolis and centripetal efforts; the intermediates go to ``steps``."""
    chain, names = joint_frames(robot), [joint.name for joint in robot.joints]
    inertias = group(chain, names, steps)
    turned = turns(chain, names, steps)
    twists = _twists(chain, turned, names, steps)
    brackets = [_bracket(twist, frame.prismatic) for twist, frame in zip(twists, chain, strict=True)]
    n = len(chain)
    matrix = sp.zeros(n, n)
    beyond = _NOTHING
    for j in range(n, 0, -1):
        frame, label = chain[j - 1], f"link {j} ({names[j - 1]})"
        composite = _joined(inertias[j - 1], twists[j - 1], beyond, j, label, steps)
        swing, unit, couple = _wrenches(composite, brackets[j - 1], frame.prismatic, j, label, steps)
        for i in range(j, 0, -1):
            here, bracket = chain[i - 1], brackets[i - 1]
            law = f"link {i} ({names[i - 1]}): Coriolis terms with joint {j}"
            matrix[i - 1, j - 1] = (swing[0] if here.prismatic else swing[1])[2]
            if i < j:
                back = bracket.omega.dot(unit[1]) + bracket.velocity.dot(unit[0])
                matrix[j - 1, i - 1] = back if here.prismatic else back + couple[2]
            if i > 1:
                swing = _inwards(f"s_{i}_{j}", swing, here, turned[i - 1], law, steps)
                unit = _inwards(f"m_{i}_{j}", unit, here, turned[i - 1], law, steps)
                couple = _turned_inwards(f"k_{i}_{j}", couple, here, turned[i - 1], law, steps)
        beyond = _seen_before(composite, frame, turned[j - 1], j, f"{label}: composite body, before its turn", steps)
    return matrix


def _twists(
    chain: Sequence[JointFrame], turned: Sequence[sp.Matrix], names: Sequence[str], steps: Steps
) -> list[_Twist]:
    found = []
    omega = velocity = sp.zeros(3, 1)
    for i, (frame, turn, name) in enumerate(zip(chain, turned, names, strict=True), start=1):
        law, qd = f"link {i} ({name})", frame.coordinate.qd
        velocity = frame.twist.T * (velocity + omega.cross(frame.position))
        velocity = steps.vector(f"v_{i}t", velocity, f"{law}: velocity, before its turn")
        omega = steps.vector(f"omega_{i}t", frame.twist.T * omega, f"{law}: angular velocity, before its turn")
        omega, velocity = turn.T * omega, turn.T * velocity
        if frame.prismatic:
            velocity += _Z * qd
        else:
            omega += _Z * qd
        omega = steps.vector(f"omega_{i}", omega, f"{law}: angular velocity")
        velocity = steps.vector(f"v_{i}", velocity, f"{law}: velocity of its frame")
        found.append(_Twist(omega, velocity))
    return found


def _bracket(twist: _Twist, prismatic: bool) -> _Twist:
    """[V, E]: the rate at which the joint's own unit twist changes with the motion of its link."""
    turning = twist.omega.cross(_Z)
    if prismatic:
        return _Twist(sp.zeros(3, 1), turning)
    return _Twist(turning, twist.velocity.cross(_Z))


def _joined(inertia: sp.Matrix, twist: _Twist, beyond: _Composite, j: int, label: str, steps: Steps) -> _Composite:
    second, first, mass = inertia[:3, :3], inertia[:3, 3], inertia[3, 3]
    law = f"{label}: composite body"
    flow = second * _skew(twist.omega).T + first * twist.velocity.T
    momentum = twist.omega.cross(first) + mass * twist.velocity
    return _Composite(
        _symmetric(f"S_{j}", second + beyond.second, law, steps),
        steps.vector(f"h_{j}", first + beyond.first, law),
        steps.name(f"m_{j}", mass + beyond.mass, law),
        steps.matrix(f"K_{j}", flow + beyond.flow, f"{law}: flow of its moments"),
        steps.vector(f"l_{j}", momentum + beyond.momentum, f"{law}: momentum"),
    )


_Wrench = tuple[sp.Matrix, sp.Matrix]  # force, and moment about the frame's origin


def _wrenches(
    body: _Composite, bracket: _Twist, prismatic: bool, j: int, label: str, steps: Steps
) -> tuple[_Wrench, _Wrench, sp.Matrix]:
    """Those of J W^T + K E^T, of J E^T, and the couple of K^T E^T, in the frame of the joint."""
    law = f"{label}: Coriolis terms"
    force = bracket.omega.cross(body.first) + body.mass * bracket.velocity
    moment = _axial(body.second * _skew(bracket.omega).T) + body.first.cross(bracket.velocity)
    k, h, s = body.flow, body.first, body.second
    if prismatic:
        unit = (_Z * body.mass, h.cross(_Z))
        couple = body.momentum.cross(_Z)
    else:
        spread = steps.name(f"K_{j}_t", k[0, 0] + k[1, 1], law)
        force += _Z.cross(body.momentum)
        moment += sp.Matrix([-k[2, 0], -k[2, 1], spread])
        unit = (_Z.cross(h), sp.Matrix([-s[0, 2], -s[1, 2], s[0, 0] + s[1, 1]]))
        couple = sp.Matrix([-k[0, 2], -k[1, 2], spread])
    swing = (steps.vector(f"s_{j}_f", force, law), steps.vector(f"s_{j}_n", moment, law))
    return swing, unit, couple


def _inwards(name: str, wrench: _Wrench, frame: JointFrame, turn: sp.Matrix, law: str, steps: Steps) -> _Wrench:
    force = _turned_inwards(f"{name}_f", wrench[0], frame, turn, law, steps)
    moment = _turned_inwards(f"{name}_n", wrench[1], frame, turn, law, steps)
    return force, steps.vector(f"{name}_b", moment + frame.position.cross(force), law)


def _turned_inwards(
    name: str, vector: sp.Matrix, frame: JointFrame, turn: sp.Matrix, law: str, steps: Steps
) -> sp.Matrix:
    return steps.vector(f"{name}t", frame.twist * steps.vector(name, turn * vector, law), law)


def _seen_before(body: _Composite, frame: JointFrame, turn: sp.Matrix, j: int, law: str, steps: Steps) -> _Composite:
    """The composite body in the frame before."""
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

    twist, p = frame.twist, frame.position
    second = _symmetric(f"S_{j}t", across(f"S_{j}", body.second), law, steps)
    second = _symmetric(f"S_{j}r", twist * second * twist.T, law, steps)
    first = steps.vector(f"h_{j}t", twist * steps.vector(f"h_{j}u", turn * body.first, law), law)
    flow = steps.matrix(f"K_{j}u", across(f"K_{j}", body.flow), law)
    flow = steps.matrix(f"K_{j}r", twist * flow * twist.T, law)
    momentum = steps.vector(f"l_{j}t", twist * steps.vector(f"l_{j}u", turn * body.momentum, law), law)
    moved = steps.vector(f"h_{j}b", first + body.mass * p, law)
    return _Composite(second + p * moved.T + first * p.T, moved, body.mass, flow + p * momentum.T, momentum)


def _symmetric(name: str, matrix: sp.Matrix, origin: str, steps: Steps) -> sp.Matrix:
    named = sp.zeros(3, 3)
    for r in range(3):
        for c in range(r, 3):
            named[r, c] = named[c, r] = steps.name(f"{name}_{r + 1}{c + 1}", matrix[r, c], origin)
    return named


def _skew(v: sp.Matrix) -> sp.Matrix:
    return sp.Matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def _axial(a: sp.Matrix) -> sp.Matrix:
    """The moment that a matrix has in tr(skew(w) a) = w . moment."""
    return sp.Matrix([a[1, 2] - a[2, 1], a[2, 0] - a[0, 2], a[0, 1] - a[1, 0]])
