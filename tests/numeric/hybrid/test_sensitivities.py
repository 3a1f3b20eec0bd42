"""Sensitivities across events: against closed forms, and against differences of whole simulations."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.drive.machine import seed_drive
from symdyn.base.errors import InputError, NumericalError
from symdyn.numeric.hybrid.affine_simulation import simulate_affine
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.saltation import Guard, jumped
from symdyn.numeric.hybrid.sensitivities import simulate_sensitivities
from symdyn.numeric.hybrid.signals import constant, step

from .machines import COULOMB, SLIDER, effect, machine

Array = NDArray[np.float64]

GEARED = """
[robot]
name = "geared"
gravity = [0, 0, 0]
[parameters]
n = 3
[dh]
rows = [["q", 0, 0, 0]]
[[joint]]
name = "arm"
link = { inertia = { about = "joint", zz = 0.5 } }
[joint.drive]
ratio = "n"
rotors = [{ name = "motor", inertia = 0.2, fixed_to_joint = true }]
"""
SERVO = "axis1_motor_position_servo"
# Relative steps of the differences: events are located to 1e-11 s, which is all the noise they have.
STEPS = {
    "R": 1e-4, "L": 1e-3, "K_T": 1e-4, "K_E": 1e-3, "T_f": 1e-3, "J_1": 1e-3, "J_2": 1e-3, "J_3": 1e-3, "J_4": 1e-4,
    "d_3": 1e-3, "d_6": 1e-3, "c_3": 1e-4, "S": 1e-3,
    f"{SERVO}_proportional": 1e-4, f"{SERVO}_derivative": 1e-3, f"{SERVO}_limit": 1e-3,
}  # fmt: skip


def test_a_block_that_slides_to_rest() -> None:
    """It stops after m v^2 / (2 F): that depends on F and v as this says, and from then on its speed on nothing."""
    speed, level, mass = 1.4, 3.0, 2.0
    block = machine(SLIDER + COULOMB)
    name = next(p for p in block.kernel.parameters if "level" in p)
    time, start = np.linspace(0.0, 2.0, 21), np.array([0.0, speed])
    found = simulate_sensitivities(block, time, [constant(0.0)], start=start, parameters=[name], initial=True)
    assert found.names == (name, "start of slide.q", "start of slide.qd")
    stop = mass * speed / level
    t = time[:, None]
    moving = np.hstack([-(t**2) / (2 * mass), np.ones_like(t), t])
    rest = np.array([-mass * speed**2 / (2 * level**2), 1.0, mass * speed / level])
    np.testing.assert_allclose(found.values[:, 0], np.where(t < stop, moving, rest), rtol=1e-9, atol=1e-12)
    rates = np.where(t < stop, np.hstack([-t / mass, 0 * t, 1 + 0 * t]), 0.0)
    np.testing.assert_allclose(found.values[:, 1], rates, rtol=1e-9, atol=1e-12)


@pytest.mark.slow
def test_the_seed_drive_against_differences() -> None:
    """All nine states, over sticking, contacts and the end of saturation, to 1e-5 of their largest derivative."""
    kernel = seed_drive().kernel
    values, time = kernel.values, np.linspace(0.0, 0.2, 41)
    start = np.array([0.02, 0.02, 0.02, 0.024, 1.0, 1.0, 1.0, 1.2, 0.1])
    found = simulate_sensitivities(
        seed_drive(), time, [step(1.0)], start=start, parameters=list(STEPS), initial=True
    )  # fmt: skip
    assert {e.kind for e in found.trajectory.events} == {"friction", "contact", "limit"}
    assert len(found.trajectory.events) >= 10

    def run(parameters: Array, x: Array) -> Array:
        return simulate_affine(Machine(kernel, parameters), time, [step(1.0)], start=x).states

    def difference(k: int) -> Array:
        parameters, states = np.zeros(len(values)), np.zeros(len(start))
        if k < len(STEPS):
            place = kernel.parameters.index(found.names[k])
            h = parameters[place] = values[place] * STEPS[found.names[k]]
        else:
            place = k - len(STEPS)
            h = states[place] = (1e-4, 1e-2)[place >= 4]
        first, second = (
            (run(values + m * parameters, start + m * states) - run(values - m * parameters, start - m * states))
            / (2 * m * h)
            for m in (1, 2)
        )
        return (4 * first - second) / 3  # Richardson

    for k, name in enumerate(found.names[:-1]):  # the current at the start has died out before it moves much
        expected = difference(k)
        error = np.abs(found.values[:, :, k] - expected).max(axis=0) / np.abs(expected).max(axis=0)
        assert error.max() < 1e-5, name


def test_a_start_alone() -> None:
    """Without parameters in question: under a force, dx/dv is the time."""
    found = simulate_sensitivities(machine(SLIDER + COULOMB), np.array([0.0, 0.5]), [constant(9.0)], initial=True)
    assert found.names == ("start of slide.q", "start of slide.qd")
    np.testing.assert_allclose(found.values[-1], [[1.0, 0.5], [0.0, 1.0]], rtol=1e-12)


def test_parameters_of_the_call_are_used() -> None:
    block = machine(SLIDER + COULOMB)
    name = next(p for p in block.kernel.parameters if "level" in p)
    values = block.kernel.values
    values[block.kernel.parameters.index(name)] = 6.0
    arguments = (np.linspace(0.0, 2.0, 5), [constant(0.0)])
    found = simulate_sensitivities(
        Machine(block.kernel, values), *arguments, start=np.array([0.0, 1.5]), parameters=[name]
    )
    assert found.values[-1, 0, 0] == pytest.approx(-2.0 * 1.5**2 / (2 * 6.0**2), rel=1e-9)


def test_a_parameter_that_moves_the_guard() -> None:
    """Friction on a rotor behind a gear: the ratio n is in its speed. It stops after (I + n^2 J) v^2 / (2 n F)."""
    geared = machine(GEARED + effect("coulomb_friction", "arm.motor", level=0.5))
    speed, level, ratio, inertia, rotor = 1.4, 0.5, 3.0, 0.5, 0.2
    found = simulate_sensitivities(
        geared, np.linspace(0.0, 5.0, 6), [constant(0.0)], start=np.array([0.0, speed]), parameters=["n"]
    )
    assert [e.after for e in found.trajectory.events] == [0]
    expected = speed**2 / (2 * level) * (rotor - inertia / ratio**2)
    assert found.values[-1, :, 0] == pytest.approx([expected, 0.0], rel=1e-9, abs=1e-12)


def test_a_guard_that_is_touched_has_no_derivative() -> None:
    touched = Guard(0.0, 0.0, np.array([1.0]), np.zeros(0))
    with pytest.raises(NumericalError, match="touched there"):
        jumped(np.eye(1), touched, 0, np.array([1.0]), np.array([2.0]), 0.5)


def test_unknown_parameters_are_refused() -> None:
    with pytest.raises(InputError, match="no such parameter: mu"):
        simulate_sensitivities(machine(SLIDER + COULOMB), np.linspace(0.0, 1.0, 3), [constant(0.0)], parameters=["mu"])
