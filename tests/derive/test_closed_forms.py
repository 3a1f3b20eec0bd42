"""Textbook arms against their closed forms, written by hand: B, C and D by themselves, efforts, energies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import pytest
import sympy as sp

from symdyn.base.symbols import parameter
from symdyn.compiler import robot_from_text
from symdyn.derive.equations import EquationsOfMotion, equations_of_motion
from symdyn.derive.lagrange import lagrange_coefficients
from symdyn.spec.records import Robot

from .exact import normal_form, required_efforts, same, substituted
from .robots import small

q1, q2 = q = sp.symbols("q_1:3", real=True)
qd = sp.symbols("qd_1:3", real=True)
qdd = sp.symbols("qdd_1:3", real=True)
g, m, r, inertia = map(parameter, ("g", "m", "r", "I"))
half = sp.Rational(1, 2)


@dataclass(frozen=True)
class ClosedForm:
    """tau = B qdd + qd C qd + D; ``potential`` is zero at the origin of the base frame."""

    robot: Robot
    B: sp.Matrix
    C: tuple[sp.Matrix, ...]
    D: Sequence[sp.Expr]
    potential: sp.Expr

    @property
    def kinetic(self) -> sp.Expr:
        speeds = sp.Matrix(qd[: len(self.D)])
        return (speeds.T * self.B * speeds)[0] / 2


def pendulum() -> ClosedForm:
    B = sp.Matrix([[inertia + m * r**2]])
    return ClosedForm(small("pendulum"), B, (sp.zeros(1),), [m * g * r * sp.cos(q1)], m * g * r * sp.sin(q1))


def two_link(name: str) -> ClosedForm:
    """Spong, Hutchinson, Vidyasagar, chapter 7 (and Craig, section 6.7, with point masses at the tips)."""
    l1, l2, m1, m2, I1, I2 = (parameter(f"{x}_{i}") for x in ("l", "m", "I") for i in (1, 2))
    if name == "two-link":
        r1, r2 = parameter("r_1"), parameter("r_2")
    else:  # its frames sit at the far ends
        r1, r2 = l1 - parameter("s_1"), l2 - parameter("s_2")
    coupling = I2 + m2 * (r2**2 + l1 * r2 * sp.cos(q2))
    far = I2 + m2 * r2**2
    near = I1 + I2 + m1 * r1**2 + m2 * (l1**2 + r2**2 + 2 * l1 * r2 * sp.cos(q2))
    h = -m2 * l1 * r2 * sp.sin(q2)
    forearm = m2 * g * r2
    upper = (m1 * r1 + m2 * l1) * g
    return ClosedForm(
        small(name),
        sp.Matrix([[near, coupling], [coupling, far]]),
        (sp.Matrix([[0, h], [h, h]]), sp.Matrix([[-h, 0], [0, 0]])),
        [upper * sp.cos(q1) + forearm * sp.cos(q1 + q2), forearm * sp.cos(q1 + q2)],
        upper * sp.sin(q1) + forearm * sp.sin(q1 + q2),
    )


def cart_pendulum() -> ClosedForm:
    """A slide, then a turn: hanging at rest at q_2 = 0, q_2 positive towards +q_1."""
    coupling = m * r * sp.cos(q2)
    return ClosedForm(
        small("cart-pendulum"),
        sp.Matrix([[parameter("m_c") + m, coupling], [coupling, inertia + m * r**2]]),
        (sp.Matrix([[0, 0], [0, -m * r * sp.sin(q2)]]), sp.zeros(2)),
        [sp.Integer(0), m * g * r * sp.sin(q2)],
        -m * g * r * sp.cos(q2),
    )


HEADER = """\
[robot]
name = "arm"
gravity = [0, "-g", 0]
[parameters]
g = { free = "m/s^2" }
"""

# A turn, then a slide along the turning arm, which points down at q_1 = 0; the arm's own inertia is about its slide.
POLAR = f"""\
{HEADER}
m = {{ free = "kg" }}
r = {{ value = 0.1, unit = "m", meaning = "from the slide's frame outwards to its centre of mass" }}
I_1 = {{ free = "kg m^2" }}
I_2 = {{ free = "kg m^2" }}
[dh]
convention = "modified"
rows = [ ["q", 0, 0, 0], [0, "q", 0, "90 deg"] ]
[[joint]]
name = "turn"
link = {{ inertia = {{ about = "joint", zz = "I_1" }} }}
[[joint]]
name = "slide"
link = {{ mass = "m", com = [0, 0, "r"], inertia = {{ about = "com", yy = "I_2" }} }}
"""


def polar() -> ClosedForm:
    reach = q2 + r
    pull = m * reach  # both of the Coriolis force 2 m rho rho' theta' and the centripetal force m rho theta'^2
    return ClosedForm(
        robot_from_text(POLAR, "polar.toml"),
        sp.diag(parameter("I_1") + parameter("I_2") + m * reach**2, m),
        (sp.Matrix([[0, pull], [pull, 0]]), sp.Matrix([[-pull, 0], [0, 0]])),
        [m * g * reach * sp.sin(q1), -m * g * sp.cos(q1)],
        -m * g * reach * sp.cos(q1),
    )


# A body with every product of inertia in two crossed axes; without mass, so that gravity finds nothing.
GIMBAL = """\
[robot]
name = "gimbal"
gravity = [0, 0, 0]
[parameters]
xx = { free = "kg m^2" }
yy = { free = "kg m^2" }
zz = { free = "kg m^2" }
xy = { free = "kg m^2" }
xz = { free = "kg m^2" }
yz = { free = "kg m^2" }
[dh]
rows = [ ["q", 0, 0, "90 deg"], ["q", 0, 0, 0] ]
[[joint]]
name = "outer"
[[joint]]
name = "inner"
link = { inertia = { xx = "xx", yy = "yy", zz = "zz", xy = "xy", xz = "xz", yz = "yz" } }
"""


def gimbal() -> ClosedForm:
    """The outer axis is (sin q_2, cos q_2, 0) in the body, so that B_11 is its moment of inertia about that."""
    xx, yy, zz, xy, xz, yz = map(parameter, ("xx", "yy", "zz", "xy", "xz", "yz"))
    s, c = sp.sin(q2), sp.cos(q2)
    h = (xx - yy) * s * c + xy * (c**2 - s**2)
    coupling = xz * s + yz * c
    return ClosedForm(
        robot_from_text(GIMBAL, "gimbal.toml"),
        sp.Matrix([[xx * s**2 + yy * c**2 + 2 * xy * s * c, coupling], [coupling, zz]]),
        (sp.Matrix([[0, h], [h, xz * c - yz * s]]), sp.Matrix([[-h, 0], [0, 0]])),
        [sp.Integer(0), sp.Integer(0)],
        sp.Integer(0),
    )


ARMS = {
    "pendulum": pendulum(),
    "two-link": two_link("two-link"),
    "two-link-standard": two_link("two-link-standard"),
    "cart-pendulum": cart_pendulum(),
    "polar": polar(),
    "gimbal": gimbal(),
}
every_arm = pytest.mark.parametrize("expected", ARMS.values(), ids=ARMS)


def assert_zero(matrix: sp.Matrix) -> None:
    assert all(normal_form(entry) == 0 for entry in matrix)


def energies(equations: EquationsOfMotion) -> tuple[sp.Expr, ...]:
    return substituted(equations.energy_steps, (equations.kinetic, equations.potential))


@every_arm
def test_inertia_coefficients(expected: ClosedForm) -> None:
    assert_zero(lagrange_coefficients(expected.robot).B - expected.B)


@every_arm
def test_coriolis_and_centripetal_coefficients(expected: ClosedForm) -> None:
    derived = lagrange_coefficients(expected.robot).C
    assert len(derived) == len(expected.C)
    for mine, theirs in zip(derived, expected.C, strict=True):
        assert_zero(mine - theirs)


@every_arm
def test_gravity_coefficients(expected: ClosedForm) -> None:
    assert_zero(sp.Matrix(lagrange_coefficients(expected.robot).D) - sp.Matrix(expected.D))


@every_arm
def test_simplified_coefficients_still_hold(expected: ClosedForm) -> None:
    short = lagrange_coefficients(expected.robot).simplified()
    assert_zero(short.B - expected.B)
    assert_zero(sp.Matrix(short.D) - sp.Matrix(expected.D))
    for mine, theirs in zip(short.C, expected.C, strict=True):
        assert_zero(mine - theirs)


@every_arm
def test_efforts_of_the_recursion(expected: ClosedForm) -> None:
    """Newton-Euler, which shares no formula with the trace form."""
    n = len(expected.D)
    speeds, accelerations = sp.Matrix(qd[:n]), sp.Matrix(qdd[:n])
    efforts = required_efforts(equations_of_motion(expected.robot))
    for i, effort in enumerate(efforts):
        motion = (expected.B[i, :] * accelerations)[0] + (speeds.T * expected.C[i] * speeds)[0]
        assert same(effort, motion + expected.D[i])


@every_arm
def test_energies(expected: ClosedForm) -> None:
    kinetic, potential = energies(equations_of_motion(expected.robot))
    assert same(kinetic, expected.kinetic)
    assert same(potential, expected.potential)


@every_arm
def test_the_closed_forms_are_of_one_piece(expected: ClosedForm) -> None:
    """The hand-written forms against each other: C by Christoffel's symbols of B, D the slope of the potential."""
    n = len(expected.D)
    for i in range(n):
        assert same(expected.D[i], sp.diff(expected.potential, q[i]))
        for j in range(n):
            for k in range(n):
                B = expected.B
                slope = sp.diff(B[i, j], q[k]) + sp.diff(B[i, k], q[j]) - sp.diff(B[j, k], q[i])
                assert same(expected.C[i][j, k], slope / 2)


# --- a rotor behind a gear ------------------------------------------------------------------------------------------

GEARED = f"""\
{HEADER}
m = {{ free = "kg" }}
r = {{ free = "m" }}
I = {{ free = "kg m^2" }}
N = {{ free = "rad/rad" }}
J = {{ free = "kg m^2" }}
[dh]
convention = "modified"
rows = [ ["q", 0, 0, 0] ]
[[joint]]
name = "pivot"
link = {{ mass = "m", com = ["r", 0, 0], inertia = {{ about = "com", zz = "I" }} }}
[joint.drive]
ratio = "N"
rotors = [{{ name = "rotor", inertia = "J", fixed_to_joint = true }}]
"""


def test_a_rotor_behind_a_gear_counts_with_the_square_of_the_ratio() -> None:
    equations = equations_of_motion(robot_from_text(GEARED, "geared.toml"))
    N, J = parameter("N"), parameter("J")
    total = inertia + m * r**2 + N**2 * J
    (effort,) = required_efforts(equations)
    kinetic, potential = energies(equations)
    assert sp.simplify(effort - total * qdd[0] - m * g * r * sp.cos(q1)) == 0
    assert sp.simplify(kinetic - half * total * qd[0] ** 2) == 0
    assert sp.simplify(potential - m * g * r * sp.sin(q1)) == 0


def test_the_arm_alone_does_not_know_its_rotor() -> None:
    """B, C and D are the rigid arm's; what the rotor needs stands beside it."""
    robot = robot_from_text(GEARED, "geared.toml")
    derived, equations = lagrange_coefficients(robot), equations_of_motion(robot)
    assert_zero(derived.B - sp.Matrix([[inertia + m * r**2]]))
    (rotor,) = equations.contributions
    assert rotor.attachment.address == "pivot.rotor"
    assert same(rotor.inertial[0], parameter("N") ** 2 * parameter("J") * qdd[0])
    assert rotor.applied == (0,)


def test_a_rotor_does_not_feel_the_arm_that_carries_it() -> None:
    """The usual neglect of gyroscopic terms: the joint that it drives gets N^2 J, the one before it nothing."""
    text = POLAR + 'drive = { ratio = "N", rotors = [{ name = "rotor", inertia = "J", fixed_to_joint = true }] }\n'
    text = text.replace("[dh]", 'N = { free = "rad/m" }\nJ = { free = "kg m^2" }\n[dh]')
    efforts = required_efforts(equations_of_motion(robot_from_text(text, "polar.toml")))
    bare = required_efforts(equations_of_motion(ARMS["polar"].robot))
    assert same(efforts[0], bare[0])
    assert same(efforts[1] - bare[1], parameter("N") ** 2 * parameter("J") * qdd[1])
