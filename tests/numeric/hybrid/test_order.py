"""The order of the integrators of general machines, measured."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from symdyn.numeric.hybrid.general_simulation import simulate_general
from symdyn.numeric.hybrid.signals import sine

from .machines import effect, machine

Array = NDArray[np.float64]

START = np.array([0.9, 0.0])

PENDULUM = """
[robot]
name = "pendulum"
gravity = [0, -9.81, 0]
[dh]
rows = [["q", 0, 1, 0]]
[[joint]]
name = "pivot"
link = { mass = 1, com = [0, 0, 0] }
"""


def steps(count: int, h: float) -> tuple[Array, Array]:
    """The state after ``count`` steps of length ``h``, and in the middle of the last of them."""
    module = machine(PENDULUM).kernel.module
    s, terms, matrix, sticks, friction, u, *_, k, y, new, levers, _, _ = module.workspace()
    none, powers, sines = np.zeros(0, np.int64), np.zeros((1, 1)), np.zeros((1, 0, 3))
    mode = (u, s, none, levers, sticks, friction, terms, matrix)
    x = START
    for i in range(count):
        k[0, :2] = x
        module._rate(x, *mode, True, k[1, :2])
        module._try(i * h, h, powers, sines, True, *mode, k, new, 1e-6, np.full(2, 1e-9))
        x = new[:2].copy()
    module._between(k, h, 2, y)
    return x, y[:2].copy()


def exact(end: float) -> Array:
    module, out = machine(PENDULUM).kernel.module, np.zeros(2)

    def rate(t: float, x: Array) -> Array:
        module.state_derivative_into(x, np.zeros(1), np.zeros(0), out)
        return out.copy()

    return np.asarray(solve_ivp(rate, (0.0, end), START, "DOP853", rtol=1e-13, atol=1e-14).y[:, -1])


def orders(errors: list[float]) -> Array:
    return np.log2(np.array(errors[:-1]) / errors[1:])


def test_a_step_is_of_order_five() -> None:
    found = orders([np.abs(steps(n, 1.0 / n)[0] - exact(1.0)).max() for n in (20, 40, 80)])
    assert np.all(np.abs(found - 5.0) < 0.5)


def test_the_interpolant_of_a_step_is_of_order_four() -> None:
    """So it is off by h^5 within a step."""
    found = orders([np.abs(steps(1, h)[1] - exact(0.5 * h)).max() for h in (0.1, 0.05, 0.025)])
    assert np.all(np.abs(found - 5.0) < 0.5)


@pytest.mark.slow  # quick: the order of a step, above
def test_events_keep_the_order() -> None:
    """Error and work over four powers of ten of the tolerance, with friction that sticks, against a tight one."""
    rig = machine(PENDULUM + effect("coulomb_friction", "pivot", level=2.0))
    time, drive = np.linspace(0.0, 5.0, 51), [sine(9.0, 0.4)]
    tight = simulate_general(rig, time, drive, tolerance=1e-13)
    assert len(tight.events) == 4
    work, errors = [], []
    for tolerance in (1e-6, 1e-8, 1e-10):
        found = simulate_general(rig, time, drive, tolerance=tolerance)
        assert len(found.events) == len(tight.events)
        work.append(found.steps)
        errors.append(np.abs(found.states - tight.states).max())
    order = -np.polyfit(np.log(work), np.log(errors), 1)[0]
    assert order > 4.0
