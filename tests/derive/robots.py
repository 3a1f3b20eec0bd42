"""Robots to derive: the textbook's small ones, and random serial arms that could be built."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import sympy as sp
from hypothesis import strategies as st

from symdyn.compiler import load_robot, robot_from_text
from symdyn.spec.records import (
    ZERO,
    Convention,
    DHRow,
    InertiaAbout,
    Joint,
    JointKind,
    Link,
    Monomial,
    Placement,
    Robot,
    Tool,
)

PENDULUM = """\
[robot]
name = "pendulum"
gravity = [0, "-g", 0]

[parameters]
g = "9.81 m/s^2"
m = "2 kg"
r = "0.5 m"
I = "0.1 kg m^2"

[dh]
convention = "modified"
rows = [ ["q", 0, 0, 0] ]

[[joint]]
name = "pivot"
link = { mass = "m", com = ["r", 0, 0], inertia = { about = "com", zz = "I" } }
"""

# As the bundled two-link, whose frames sit at the near ends; here they sit at the far ends.
TWO_LINK_STANDARD = """\
[robot]
name = "two-link-standard"
gravity = [0, "-g", 0]

[parameters]
g = "9.81 m/s^2"
l_1 = "0.5 m"
l_2 = "0.4 m"
m_1 = "1.08 kg"
m_2 = "0.864 kg"
s_1 = { value = 0.25, unit = "m", meaning = "elbow back to the centre of mass of link 1" }
s_2 = { value = 0.2, unit = "m", meaning = "tip back to the centre of mass of link 2" }
I_1 = "0.02 kg m^2"
I_2 = "0.01 kg m^2"

[dh]
convention = "standard"
rows = [ ["q", 0, "l_1", 0],
         ["q", 0, "l_2", 0] ]

[[joint]]
name = "shoulder"
link = { mass = "m_1", com = ["-s_1", 0, 0], inertia = { about = "com", zz = "I_1" } }

[[joint]]
name = "elbow"
link = { mass = "m_2", com = ["-s_2", 0, 0], inertia = { about = "com", zz = "I_2" } }
"""

# The base's x points down and its z along the rail; the pendulum hangs at rest at q_2 = 0.
CART_PENDULUM = """\
[robot]
name = "cart-pendulum"
gravity = ["g", 0, 0]

[parameters]
g = "9.81 m/s^2"
m_c = "3 kg"
m = "2 kg"
r = "0.5 m"
I = "0.1 kg m^2"

[dh]
convention = "modified"
rows = [ [ 0,  "q", 0, 0],
         ["q", 0,   0, "90 deg"] ]

[[joint]]
name = "cart"
link = { mass = "m_c" }

[[joint]]
name = "pendulum"
link = { mass = "m", com = ["r", 0, 0], inertia = { about = "com", zz = "I" } }
"""

_TEXTS = {"pendulum": PENDULUM, "two-link-standard": TWO_LINK_STANDARD, "cart-pendulum": CART_PENDULUM}
SMALL = (*_TEXTS, "two-link", "irb6-arm", "irb6-arm-rod")


def small(name: str) -> Robot:
    """A robot of this file or a bundled machine, by name."""
    return robot_from_text(_TEXTS[name], name) if name in _TEXTS else load_robot(name)


def plain(value: Fraction | float) -> Monomial:
    return Monomial(value) if value else ZERO


_LENGTH = st.fractions(-1, 1, max_denominator=20)
_TWIST = st.one_of(
    st.sampled_from([0.0, math.pi / 2, -math.pi / 2, math.pi, math.pi / 6]), st.fractions(-3, 3, max_denominator=10)
)
_MASS = st.fractions(Fraction(1, 5), 5, max_denominator=20)
_SPREAD = st.fractions(Fraction(1, 100), Fraction(1, 2), max_denominator=100)  # mean squared extent, m^2


def _turned(principal: sp.Matrix, axis: tuple[Fraction, ...]) -> sp.Matrix:
    rotation = _rotation(axis)
    return rotation * principal * rotation.T


def _rotation(axis: tuple[Fraction, ...]) -> sp.Matrix:
    """Cayley's rational rotation."""
    x, y, z = (sp.Rational(a.numerator, a.denominator) for a in axis)
    skew = sp.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return (sp.eye(3) - skew).inv() * (sp.eye(3) + skew)


@st.composite
def links(draw: st.DrawFn) -> Link:
    """A body with mass spread in all three directions, so that its pseudo-inertia is positive definite."""
    mass = draw(_MASS)
    com = tuple(draw(_LENGTH) for _ in range(3))
    spread = [sp.Rational(s.numerator, s.denominator) for s in (draw(_SPREAD), draw(_SPREAD), draw(_SPREAD))]
    tensor = sp.diag(*[sum(spread) - s for s in spread]) * sp.Rational(mass.numerator, mass.denominator)
    tensor = _turned(tensor, tuple(draw(_LENGTH) for _ in range(3)))
    about = draw(st.sampled_from(InertiaAbout))
    if about is InertiaAbout.JOINT:
        c = sp.Matrix([sp.Rational(e.numerator, e.denominator) for e in com])
        tensor += sp.Rational(mass.numerator, mass.denominator) * (c.dot(c) * sp.eye(3) - c * c.T)
    entries = [tensor[i, k] for i, k in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    exact = [plain(Fraction(int(e.p), int(e.q))) for e in entries]
    return Link(
        plain(mass),
        (plain(com[0]), plain(com[1]), plain(com[2])),
        (exact[0], exact[1], exact[2], exact[3], exact[4], exact[5]),
        about,
    )


@st.composite
def serial_robots(draw: st.DrawFn, most_joints: int = 5) -> Robot:
    """1 to ``most_joints`` joints, revolute and prismatic mixed, either convention, any direction of gravity."""
    joints = []
    for i in range(draw(st.integers(1, most_joints))):
        row = DHRow(plain(draw(_TWIST)), plain(draw(_LENGTH)), plain(draw(_LENGTH)), plain(draw(_TWIST)))
        joints.append(Joint(f"joint{i + 1}", draw(st.sampled_from(JointKind)), row, draw(links())))
    pull = [plain(draw(st.fractions(-10, 10, max_denominator=10))) for _ in range(3)]
    convention = draw(st.sampled_from(Convention))
    return Robot("random", "", convention, (pull[0], pull[1], pull[2]), tuple(joints), (), ())


@st.composite
def placements(draw: st.DrawFn) -> Placement:
    """A frame at any place, turned by rational angles."""
    position = tuple(plain(draw(_LENGTH)) for _ in range(3))
    turned = _rotation(tuple(draw(_LENGTH) for _ in range(3)))
    x, y, z = (tuple(float(turned[r, c]) for c in range(3)) for r in range(3))
    return Placement(
        (position[0], position[1], position[2]), ((x[0], x[1], x[2]), (y[0], y[1], y[2]), (z[0], z[1], z[2]))
    )


@st.composite
def equipped_robots(draw: st.DrawFn, most_joints: int = 4) -> tuple[Robot, dict[str, list[float]]]:
    """A random robot on a base, with or without a tool, and q, qd, qdd."""
    robot = draw(serial_robots(most_joints))
    tool = draw(st.none() | st.builds(Tool, placements(), st.just(Link()) | links()))
    robot = replace(robot, base=draw(st.none() | placements()), tool=tool)
    return robot, draw(states(robot))


def states(robot: Robot) -> st.SearchStrategy[dict[str, list[float]]]:
    """Random q, qd, qdd for a robot without drives."""
    n = len(robot.joints)
    vector = st.lists(st.floats(-3, 3).map(lambda value: round(value, 6)), min_size=n, max_size=n)
    return st.fixed_dictionaries({"q": vector, "qd": vector, "qdd": vector})


@st.composite
def moving_robots(draw: st.DrawFn, most_joints: int = 5) -> tuple[Robot, dict[str, list[float]]]:
    """A random robot, and q, qd, qdd."""
    robot = draw(serial_robots(most_joints))
    return robot, draw(states(robot))
