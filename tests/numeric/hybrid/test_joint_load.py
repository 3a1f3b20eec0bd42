"""Friction that depends on the load of a rigid joint: motion in closed form, and laws by hand."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.base.errors import InputError
from symdyn.compiler import compile_hybrid, compile_robot, robot_from_text
from symdyn.emit.kernel import Kernel
from symdyn.numeric.hybrid.signals import Signal, constant
from symdyn.numeric.hybrid.simulate import simulate_events
from tests.numeric.hybrid.machines import COULOMB, PAIR, SLIDER, SPRING, effect, machine

MU = 0.25
BY_LOAD = effect("load_dependent_friction", "slide", coefficient=MU)
ARM = """
[robot]
name = "arm"
gravity = [0, -9.81, 0]
[dh]
convention = "modified"
rows = [["q", 0, 0, 0], ["q", 0, 0.5, 0]]
[[joint]]
name = "shoulder"
link = { mass = 2, com = [0.2, 0.1, 0], inertia = { zz = 0.3 } }
[[joint]]
name = "elbow"
link = { mass = 1, com = [0.3, 0, 0], inertia = { zz = 0.1 } }
"""
PLAIN = {"viscous_friction": 0.4, "coulomb_friction": 0.7}
SPRUNG = effect("linear_spring", "shoulder", stiffness=3.0) + effect("added_inertia", "elbow", inertia=0.2)
NUMBER = st.floats(-3.0, 3.0).filter(lambda x: abs(x) > 1e-3)


def run(text: str, force: float, start: list[float], end: float = 6.0) -> np.ndarray:
    time = np.linspace(0.0, end, 601)
    signals: list[Signal] = [constant(force)]
    return simulate_events(machine(text), time, signals, start=np.array(start), tolerance=1e-10).states


@pytest.mark.slow
def test_without_effort_it_is_coulomb_friction_and_more() -> None:
    """load + mu |load| = -F while moving up: as Coulomb's law with F / (1 - mu), moving and sticking."""
    found = run(SLIDER + SPRING + COULOMB + BY_LOAD, 0.0, [2.0, 0.0])
    same = run(SLIDER + SPRING + effect("coulomb_friction", "slide", level=3.0 / (1.0 - MU)), 0.0, [2.0, 0.0])
    assert np.allclose(found, same, atol=1e-7)
    assert found[-1, 1] == 0.0  # it stuck
    assert abs(found[-1, 0]) > 0.1


@pytest.mark.slow
def test_under_a_steady_effort() -> None:
    """Up: about u / (1 + mu) over k; back: about u / (1 - mu) over k; where that holds, it sticks."""
    omega, up, back = 3.0, 10.0 / (1.0 + MU) / 18.0, 10.0 / (1.0 - MU) / 18.0
    time = np.linspace(0.0, 6.0, 601)
    x = run(SLIDER + SPRING + BY_LOAD, 10.0, [0.0, 0.0])[:, 0]
    half = np.pi / omega
    first, second = time < half, (time >= half) & (time < 2.0 * half)
    assert np.allclose(x[first], up * (1.0 - np.cos(omega * time[first])), atol=1e-8)
    turn = 2.0 * up
    assert np.allclose(x[second], back + (turn - back) * np.cos(omega * (time[second] - half)), atol=1e-8)
    assert np.allclose(x[time > 2.0 * half], 2.0 * back - turn, atol=1e-8)


@cache
def kernel(loaded: bool) -> Kernel:
    text = ARM + SPRUNG
    for place in ("shoulder", "elbow"):
        text += "".join(
            effect(kind, place, **{"level" if kind.startswith("coulomb") else "coefficient": value})
            for kind, value in PLAIN.items()
        )
        text += effect("load_dependent_friction", place, coefficient=MU) if loaded else ""
    return compile_robot(robot_from_text(text, "arm.toml")).kernel()


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(st.lists(NUMBER, min_size=6, max_size=6))
def test_inverse_dynamics_is_the_law_and_forward_dynamics_its_inverse(numbers: list[float]) -> None:
    q, qd, qdd = np.array(numbers).reshape(3, 2)
    p = kernel(False).values
    without = kernel(False).inverse_dynamics(q, qd, qdd)
    load = without - PLAIN["viscous_friction"] * qd - PLAIN["coulomb_friction"] * np.sign(qd)
    tau = kernel(True).inverse_dynamics(q, qd, qdd)
    assert np.allclose(tau, without + MU * np.abs(load) * np.sign(qd), atol=1e-12)
    assert np.allclose(kernel(True).forward_dynamics(q, qd, tau), qdd, atol=1e-9)
    assert len(p) + 2 == len(kernel(True).values)


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(st.lists(NUMBER, min_size=6, max_size=6))
def test_derivatives(numbers: list[float]) -> None:
    """By central differences; kinks of |load| apart."""
    k, x, u = kernel(True), np.array(numbers[:4]), np.array(numbers[4:])
    p, q, qd = k.values, x[:2].copy(), x[2:].copy()
    tests = [
        (k.state_derivative_state_jacobian_p(x, u, p), lambda y: k.state_derivative_p(y, u, p), x),
        (k.state_derivative_input_jacobian_p(x, u, p), lambda y: k.state_derivative_p(x, y, p), u),
        (k.state_derivative_parameter_jacobian_p(x, u, p), lambda y: k.state_derivative_p(x, u, y), p),
        (k.forward_dynamics_state_jacobian_p(q, qd, u, p), lambda y: k.forward_dynamics_p(y[:2], y[2:], u, p), x),
        (k.inverse_dynamics_state_jacobian_p(q, qd, u, p), lambda y: k.inverse_dynamics_p(y[:2], y[2:], u, p), x),
        (k.inverse_dynamics_parameter_jacobian_p(q, qd, u, p), lambda y: k.inverse_dynamics_p(q, qd, u, y), p),
    ]
    for jacobian, function, at in tests:
        sides = [
            np.stack([(function(at + h * e) - function(at)) / h for e in np.eye(len(at))], axis=1)
            for h in (1e-6, -1e-6)
        ]
        smooth = np.all(np.abs(sides[0] - sides[1]) < 1e-2)  # no kink nearby
        assert not smooth or np.allclose(jacobian, 0.5 * (sides[0] + sides[1]), atol=1e-5)


@settings(max_examples=20, deadline=None)
@given(st.lists(NUMBER, min_size=6, max_size=6))
def test_power_in_and_out_is_the_growth_of_what_is_stored(numbers: list[float]) -> None:
    x, u = np.array(numbers[:4]), np.array(numbers[4:])
    by_load = "".join(effect("load_dependent_friction", place, coefficient=MU) for place in ("shoulder", "elbow"))
    found = machine(ARM + SPRUNG + effect("coulomb_friction", "elbow", level=0.7) + by_load)
    modes = np.sign([x[2 + ("shoulder", "elbow").index(name)] for name in found.switches])
    rate, h = found.call("state_derivative", x, u, modes), 1e-6
    after, before = (found.call("stored_energy", x + s * h * rate, u, modes).sum() for s in (1, -1))
    going = found.call("supplied_power", x, u, modes).sum() - found.call("dissipated_power", x, u, modes).sum()
    assert (after - before) / (2.0 * h) == pytest.approx(going, abs=1e-5 * (1.0 + abs(going)))
    assert np.all(found.call("dissipated_power", x, u, modes) >= 0.0)


def test_more_than_all_of_the_load_is_refused() -> None:
    with pytest.raises(InputError, match="SD203"):
        robot_from_text(SLIDER + effect("load_dependent_friction", "slide", coefficient=1.0), "slider.toml")


def test_a_load_with_friction_of_another_place_is_refused_by_event_simulation() -> None:
    """The force of the shaft, which brings the load, has dry friction of its own."""
    text = PAIR + effect("coulomb_friction", "arm.shaft", level=1.0)
    compile_hybrid(robot_from_text(text, "machine.toml"))
    with pytest.raises(InputError, match="SD451"):
        compile_hybrid(robot_from_text(text + effect("load_dependent_friction", "arm", coefficient=0.1), "m.toml"))
