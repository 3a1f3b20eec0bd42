"""Simulation against closed forms: oscillators, a pendulum, friction that stops; and what it refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import integrate, special

from symdyn.base.errors import InputError, NumericalError
from symdyn.compiler import compile_robot, robot_from_text
from symdyn.emit.kernel import Kernel
from symdyn.numeric.simulate import Trajectory, simulate

Array = NDArray[np.float64]

SLIDER = """
[robot]
name = "slider"
gravity = [0, 0, 0]
[parameters]
m = "2 kg"
k = "18 N/m"
b = "1.2 N s/m"
[dh]
convention = "modified"
rows = [[0, "q", 0, 0]]
[[joint]]
name = "slide"
link = { mass = "m" }
"""
DRIVEN = SLIDER + 'actuator = { gain = "1 N/V" }\n'
SPRING = '[[effect]]\ntype = "linear_spring"\nat = "slide"\nstiffness = "k"\n'
DAMPER = '[[effect]]\ntype = "viscous_friction"\nat = "slide"\ncoefficient = "b"\n'
COULOMB = '[[effect]]\ntype = "coulomb_friction"\nat = "slide"\nlevel = "3 N"\n'
PENDULUM = """
[robot]
name = "plain-pendulum"
gravity = [0, "-g", 0]
[parameters]
g = "9.81 m/s^2"
m = "1.5 kg"
r = "0.4 m"
[dh]
convention = "modified"
rows = [["q", 0, 0, 0]]
[[joint]]
name = "swing"
link = { mass = "m", com = ["r", 0, 0] }
"""
TWO_LINK = """
[robot]
name = "double-pendulum"
gravity = [0, "-g", 0]
[parameters]
g = "9.81 m/s^2"
[dh]
convention = "modified"
rows = [["q", 0, 0, 0], ["q", 0, "0.5 m", 0]]
[[joint]]
name = "upper"
link = { mass = "1 kg", com = ["0.3 m", 0, 0], inertia = { about = "com", zz = "0.02 kg m^2" } }
[[joint]]
name = "lower"
link = { mass = "0.7 kg", com = ["0.2 m", 0, 0], inertia = { about = "com", zz = "0.01 kg m^2" } }
"""
MASS, STIFFNESS, DAMPING = 2.0, 18.0, 1.2


def kernel(*parts: str, smoothing: float | None = None) -> Kernel:
    return compile_robot(robot_from_text("\n".join(parts), "test.toml"), smoothing).kernel()


@pytest.fixture(scope="module")
def oscillator() -> Kernel:
    return kernel(SLIDER, SPRING, DAMPER)


def energies(of: Kernel, run: Trajectory) -> Array:
    n = len(of.coordinates)
    return np.array([np.sum(of.energy(x[:n].copy(), x[n:].copy())) for x in run.states])


def test_damped_oscillation_is_the_closed_form(oscillator: Kernel) -> None:
    time = np.linspace(0, 8, 200)
    run = simulate(oscillator, time, start=np.array([0.5, 0.0]))
    decay = DAMPING / (2 * MASS)
    omega = math.sqrt(STIFFNESS / MASS - decay**2)
    expected = 0.5 * np.exp(-decay * time) * (np.cos(omega * time) + decay / omega * np.sin(omega * time))
    np.testing.assert_allclose(run.states[:, 0], expected, atol=2e-7)
    np.testing.assert_allclose(run.states[:, 1], np.gradient(expected, time, edge_order=2), atol=0.03)
    assert np.array_equal(run.time, time)


def test_tolerance_is_what_sets_the_error(oscillator: Kernel) -> None:
    time, start = np.linspace(0, 8, 50), np.array([0.5, 0.0])
    fine = simulate(oscillator, time, start=start, tolerance=1e-11)
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8):
        run = simulate(oscillator, time, start=start, tolerance=tolerance)
        errors.append(float(np.max(np.abs(run.states - fine.states))))
        assert errors[-1] < 100 * tolerance
    assert errors[0] > 10 * errors[1] > 100 * errors[2]


def test_force_at_the_input_reaches_its_static_deflection_with_the_gain_of_a_resonance() -> None:
    driven = kernel(DRIVEN, SPRING, DAMPER)
    omega, force = 2.5, 4.0
    time = np.linspace(0, 60, 1200)
    run = simulate(driven, time, lambda t: np.array([force * math.cos(omega * t)]))
    response = 1.0 / (STIFFNESS - MASS * omega**2 + 1j * DAMPING * omega)
    settled = time > 45  # the start has decayed by exp(-0.3 * 45) = 1e-6
    expected = np.real(force * response * np.exp(1j * omega * time))
    np.testing.assert_allclose(run.states[settled, 0], expected[settled], atol=2e-6)
    np.testing.assert_allclose(run.inputs[:, 0], force * np.cos(omega * time), rtol=1e-15)


@pytest.mark.parametrize("swing", [0.1, 1.5, 3.0])
def test_period_of_the_pendulum_is_the_elliptic_integral(swing: float) -> None:
    """4 sqrt(r / g) K(sin^2(swing / 2)); the angle of rest is -90 degrees from the x axis."""
    period = 4 * math.sqrt(0.4 / 9.81) * float(special.ellipk(math.sin(swing / 2) ** 2))
    start = np.array([-math.pi / 2 + swing, 0.0])
    run = simulate(kernel(PENDULUM), np.array([0, period / 4, period / 2, period]), start=start, tolerance=1e-10)
    rest = -math.pi / 2
    np.testing.assert_allclose(run.states[:, 0] - rest, [swing, 0.0, -swing, swing], atol=1e-6)


@pytest.mark.parametrize("model", [PENDULUM, pytest.param(TWO_LINK, marks=pytest.mark.slow)])
def test_energy_is_kept_where_nothing_takes_it(model: str) -> None:
    machine = kernel(model)
    n = len(machine.coordinates)
    start = np.concatenate([np.linspace(0.9, -0.6, n), np.linspace(0.5, 2.0, n)])
    run = simulate(machine, np.linspace(0, 5, 200), start=start, tolerance=1e-10)
    energy = energies(machine, run)
    np.testing.assert_allclose(energy, energy[0], atol=1e-6)
    assert np.ptp(run.states[:, 0]) > 1.0  # it does swing


def test_energy_falls_by_what_the_damper_takes(oscillator: Kernel) -> None:
    time = np.linspace(0, 5, 4001)
    run = simulate(oscillator, time, start=np.array([0.5, 0.0]))
    energy = energies(oscillator, run)
    assert np.all(np.diff(energy) < 1e-9)
    taken = DAMPING * integrate.trapezoid(run.states[:, 1] ** 2, time)
    assert energy[0] - energy[-1] == pytest.approx(taken, rel=1e-5)


def test_coulomb_friction_stops_the_slider_where_it_should() -> None:
    """From v0 at constant deceleration F / m: after t = m v0 / F, at m v0^2 / (2 F)."""
    width, speed, level = 1e-4, 1.5, 3.0
    machine = kernel(SLIDER, COULOMB, smoothing=width)
    stop, way = MASS * speed / level, MASS * speed**2 / (2 * level)
    run = simulate(machine, np.array([0.0, stop / 2, 1.5 * stop, 3 * stop]), start=np.array([0.0, speed]))
    assert run.states[1] == pytest.approx([0.75 * way, speed / 2], rel=1e-5)
    for x, v in run.states[2:]:
        assert x == pytest.approx(way, abs=20 * width)
        assert abs(v) < width


def test_table_names_every_column_with_its_unit(oscillator: Kernel) -> None:
    run = simulate(oscillator, np.linspace(0, 1, 5), start=np.array([0.5, 0.0]))
    table = run.table(oscillator)
    assert [name for name in table if "slide" in name][:2] == ["slide.q [m]", "slide.qd [m/s]"]
    assert next(iter(table)) == "time [s]"
    assert np.array_equal(table["slide.q [m]"], run.states[:, 0])


def test_without_start_and_inputs_it_rests_at_the_origin(oscillator: Kernel) -> None:
    assert np.all(simulate(oscillator, np.linspace(0, 1, 5)).states == 0.0)


def test_progress_is_told_the_time(oscillator: Kernel) -> None:
    seen: list[float] = []
    simulate(oscillator, np.linspace(0, 2, 5), start=np.array([0.5, 0.0]), progress=seen.append)
    assert min(seen) == 0.0
    assert max(seen) == pytest.approx(2.0)


@pytest.mark.parametrize(
    "time", [[], [0.0], [0.0, 0.0], [0.0, 1.0, 0.5], [1.0, 0.0], [0.0, math.nan, 1.0], [0.0, math.inf]]
)
def test_bad_times_are_refused(oscillator: Kernel, time: list[float]) -> None:
    with pytest.raises(InputError, match="increasing") as caught:
        simulate(oscillator, np.array(time))
    assert [problem.code for problem in caught.value.problems] == ["SD302"]


@pytest.mark.parametrize("start", [[0.0], [0.0, 0.0, 0.0], [math.nan, 0.0], [0.0, math.inf], [[0.0, 0.0]]])
def test_bad_start_is_refused(oscillator: Kernel, start: list[float]) -> None:
    with pytest.raises(InputError, match="2 finite numbers") as caught:
        simulate(oscillator, np.linspace(0, 1, 5), start=np.array(start))
    assert [problem.code for problem in caught.value.problems] == ["SD302"]


def test_solver_that_gives_up_says_when_and_what_was_fastest() -> None:
    """A force of 1 / (1 - t)^2 gives an infinite speed at t = 1 s."""
    driven = kernel(DRIVEN, SPRING, DAMPER)
    with pytest.raises(NumericalError) as caught:
        simulate(driven, np.linspace(0, 5, 51), lambda t: np.array([1.0 / (1.0 - t) ** 2]))
    (told,) = caught.value.problems
    assert told.code == "SD303"
    assert "t = 0.9 s" in told.message
    assert "slide.qd" in told.hint
