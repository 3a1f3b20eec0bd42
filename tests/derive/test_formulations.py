"""Two roads to one law: Newton-Euler and Lagrange for arms, force balance and extended Lagrange for drives."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mpf, workdps

from symdyn.base.nonsmooth import absorb
from symdyn.derive.coordinates import coordinates
from symdyn.derive.equations import equations_of_motion
from symdyn.derive.forces import balance, lagrange
from symdyn.derive.lagrange import lagrange_coefficients
from symdyn.derive.ports import attachments
from symdyn.physics import catalogue
from symdyn.spec.records import JOINT_END, Drive, EffectSpec, Monomial, PlaceKind, Robot, Rotor, Shaft

from .drives import BELT, driven, letter
from .evaluation import DIGITS, close, energy, function, inverse_dynamics, mass_matrix
from .exact import required_efforts, same
from .robots import SMALL, moving_robots, small

State = dict[str, list[float]]


@pytest.mark.parametrize("name", SMALL)
def test_newton_euler_equals_lagrange_symbolically(name: str) -> None:
    robot = small(name)
    by_newton = required_efforts(equations_of_motion(robot))
    by_lagrange = lagrange_coefficients(robot).efforts()
    assert len(by_newton) == len(robot.joints)
    for first, second in zip(by_newton, by_lagrange, strict=True):
        assert first.free_symbols
        assert same(first, second)


@pytest.mark.parametrize("name", SMALL)
def test_simplified_coefficients_are_the_same_and_no_longer(name: str) -> None:
    derived = lagrange_coefficients(small(name))
    short = derived.simplified()
    for raw, simple in [
        *zip(derived.B, short.B, strict=True),
        *((a, b) for i in range(len(derived.C)) for a, b in zip(derived.C[i], short.C[i], strict=True)),
        *zip(derived.D, short.D, strict=True),
    ]:
        assert same(raw, simple)
        assert simple.count_ops() <= sp.expand(raw).count_ops()


@settings(max_examples=15, deadline=None)
@given(moving_robots(most_joints=4))
def test_newton_euler_equals_lagrange_on_random_robots(case: tuple[Robot, State]) -> None:
    robot, state = case
    equations = equations_of_motion(robot)
    by_lagrange = function(equations.axes, (), lagrange_coefficients(robot).efforts())
    assert close(inverse_dynamics(equations)(state), np.array(by_lagrange(state), dtype=float), 1e-13)


@settings(max_examples=25, deadline=None)
@given(moving_robots())
def test_the_mass_matrix_is_symmetric_and_positive_definite(case: tuple[Robot, State]) -> None:
    robot, state = case
    mass = mass_matrix(equations_of_motion(robot), state["q"])
    assert close(mass, mass.T, 1e-13)
    assert np.linalg.eigvalsh(mass).min() > 0


@settings(max_examples=15, deadline=None)
@given(moving_robots(most_joints=4))
def test_kinetic_energy_is_half_the_mass_matrix_between_speeds(case: tuple[Robot, State]) -> None:
    robot, state = case
    equations = equations_of_motion(robot)
    speed = np.array(state["qd"])
    kinetic, _ = energy(equations)(state)
    assert close([float(kinetic)], [speed @ mass_matrix(equations, state["q"]) @ speed / 2], 1e-13)


@settings(max_examples=25, deadline=None)
@given(moving_robots())
def test_the_efforts_supply_the_change_of_energy(case: tuple[Robot, State]) -> None:
    """d/dt (K + U) = tau . qd, by a central difference in forty digits."""
    robot, state = case
    equations = equations_of_motion(robot)
    power = float(inverse_dynamics(equations)(state) @ np.array(state["qd"]))
    total = energy(equations)
    with workdps(DIGITS):
        h = mpf(10) ** -12
        rate = (sum(total(_moved(state, h))) - sum(total(_moved(state, -h)))) / (2 * h)
    assert close([float(rate)], [power], 1e-12)


def _moved(state: State, time: mpf) -> dict[str, list[mpf]]:
    steps = zip(state["q"], state["qd"], state["qdd"], strict=True)
    moved = [(q + qd * time + qdd * time**2 / 2, qd + qdd * time) for q, qd, qdd in steps]
    return {"q": [q for q, _ in moved], "qd": [qd for _, qd in moved], "qdd": state["qdd"]}


def by_both_routes(robot: Robot) -> list[tuple[sp.Expr, sp.Expr]]:
    """Per coordinate: inertial less applied force by balance at each port, and by Lagrange on the totals."""
    axes, items = coordinates(robot), attachments(robot)
    parts = [balance(item, axes) for item in items]
    balanced = [sum((c.inertial[k] - c.applied[k] for c in parts), sp.Integer(0)) for k in range(len(axes))]
    return list(zip(balanced, lagrange(items, axes), strict=True))


def assert_routes_agree(robot: Robot) -> None:
    for balanced, total in by_both_routes(robot):
        assert absorb(sp.expand(balanced - total)) == 0


def test_the_drive_of_the_irb6_by_balance_and_by_lagrange() -> None:
    robot = small("irb6-axis1")
    assert all(total != 0 for _, total in by_both_routes(robot))
    assert_routes_agree(robot)


KINDS = {"arm": PlaceKind.JOINT, "arm.motor": PlaceKind.INERTIA, "arm.belt": PlaceKind.SHAFT}


PLACED = [
    (identifier, address)
    for identifier, effect in catalogue().items()
    for address, kind in KINDS.items()
    if kind in effect.attaches_to and effect.stage >= 0  # what comes ahead of loops needs one
]


@pytest.mark.parametrize(("identifier", "address"), PLACED)
def test_every_effect_by_balance_and_by_lagrange(identifier: str, address: str) -> None:
    """Each effect wherever it attaches, beside a backlash that shows whether forces see what a port lets through."""
    effect = catalogue()[identifier]
    values = tuple((p.name, letter(p.name)) for p in effect.parameters)
    slack = EffectSpec("backlash", "arm.belt", (("clearance", letter("S")),))
    effects = (EffectSpec(identifier, address, values), *(() if identifier == "backlash" else (slack,)))
    undriven = identifier in ("effort_gain", "effort_saturation")
    drive = replace(BELT, motor=None) if undriven else BELT  # whose motor drives the joint
    assert_routes_agree(driven(drive, effects))


PROPOSABLE = [
    identifier
    for identifier, effect in catalogue().items()
    if PlaceKind.JOINT in effect.attaches_to and effect.stage >= 0
]


@st.composite
def random_drives(draw: st.DrawFn) -> Robot:
    """Up to four rotors, one perhaps fixed to the joint, shafts between any two, a ratio, effects anywhere."""
    count = draw(st.integers(1, 4))
    fixed = draw(st.integers(0, count))  # the last one if equal to count, else none
    rotors = tuple(Rotor(f"r{i}", letter(f"J_{i}"), i == fixed) for i in range(1, count + 1))
    names = [*(r.name for r in rotors), JOINT_END]
    pairs = draw(st.lists(st.permutations(names).map(lambda order: (order[0], order[1])), max_size=4, unique=True))
    shafts = tuple(Shaft(f"s{i}", a, b, letter(f"c_{i}"), letter(f"d_{i}")) for i, (a, b) in enumerate(pairs))
    ratio = draw(st.sampled_from([Monomial(Fraction(1)), Monomial(Fraction(-5, 2)), letter("N")]))
    places = ["arm", *(f"arm.{r.name}" for r in rotors)]
    effects = [
        EffectSpec(
            identifier, place, tuple((p.name, letter(f"{p.name}_{i}")) for p in catalogue()[identifier].parameters)
        )
        for i, (identifier, place) in enumerate(
            draw(st.lists(st.tuples(st.sampled_from(PROPOSABLE), st.sampled_from(places)), max_size=4))
        )
    ]
    slack = [
        EffectSpec("backlash", f"arm.{s.name}", (("clearance", letter("S")),)) for s in shafts if draw(st.booleans())
    ]
    return driven(Drive(ratio, rotors, shafts, None), (*effects, *slack))


@settings(max_examples=30, deadline=None)
@given(random_drives())
def test_random_drives_by_balance_and_by_lagrange(robot: Robot) -> None:
    assert_routes_agree(robot)
