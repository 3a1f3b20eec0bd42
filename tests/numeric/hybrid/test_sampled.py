"""Sampled servo loops against the difference equations that they are, by both ways of simulating."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from benchmarks.drive.machine import SERVO
from symdyn.base.errors import InputError
from symdyn.compiler import compile_hybrid, compile_robot, linearise, load_robot, robot_from_text
from symdyn.numeric.hybrid.affine_simulation import simulate_affine
from symdyn.numeric.hybrid.batch import simulate_batch
from symdyn.numeric.hybrid.energy import energy_balance
from symdyn.numeric.hybrid.general_simulation import simulate_general
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.samples import samples
from symdyn.numeric.hybrid.sensitivities import simulate_sensitivities
from symdyn.numeric.hybrid.signals import constant, step

from .machines import effect, machine
from .test_events import Way

Array = NDArray[np.float64]

ways = pytest.mark.parametrize(
    ("way", "close"),
    [
        pytest.param(simulate_affine, 1e-11, id="exact"),
        pytest.param(partial(simulate_general, tolerance=1e-10), 1e-9, id="general", marks=pytest.mark.slow),
    ],
)

# Without back-EMF and inductance the speed is the integral of the voltage: dv/dt = GAIN u.
WHEEL = """
[robot]
name = "wheel"
gravity = [0, 0, 0]
[dh]
rows = [["q", 0, 0, 0]]
[[joint]]
name = "wheel"
link = { inertia = { about = "joint", zz = 0.2 } }
[joint.drive]
rotors = [{ name = "motor", inertia = 0.05, fixed_to_joint = true }]
motor = { name = "circuit", at = "motor", resistance = 2, inductance = 0, torque_constant = 0.8, back_emf_constant = 0 }
"""
INERTIA, PER_VOLT = 0.25, 0.4
GAIN = PER_VOLT / INERTIA
T = 0.01


def loop(**values: float) -> str:
    return WHEEL + effect("speed_loop", "wheel.motor", **({"limit": 1e6} | values))


@ways
def test_a_proportional_loop_on_an_integrator_is_a_geometric_series(way: Way, close: float) -> None:
    """e_k = (1 - K T)^k, here with K T = 0.64; between samples the speed is a straight line."""
    t = np.linspace(0.0, 0.2, 41)
    found = way(machine(loop(proportional=40.0, period=T)), t, [constant(3.0)])
    at_samples = 3.0 * (1.0 - (1.0 - GAIN * 40.0 * T) ** np.arange(21))
    expected = np.interp(t, T * np.arange(21), at_samples)
    assert np.allclose(found.states[:, 1], expected, rtol=0.0, atol=close)
    held = 40.0 * (3.0 - at_samples)[np.arange(41) // 2]
    assert np.allclose(found.states[:, 2], held, rtol=0.0, atol=close * 100)  # right after the sample, at samples


@pytest.mark.parametrize("share", [0.25, 1.0])
def test_a_delay_makes_it_a_difference_equation_of_second_order(share: float) -> None:
    """Over a period the output of the sample before acts first, for the delay; all of it with a delay of a period."""
    t = np.linspace(0.0, 0.4, 41)
    found = simulate_affine(machine(loop(proportional=20.0, period=T, delay=share * T)), t, [constant(3.0)])
    v, before, expected = 0.0, 0.0, []
    for _ in t:
        expected.append(v)
        asked = 20.0 * (3.0 - v)
        v, before = v + GAIN * T * (share * before + (1.0 - share) * asked), asked
    assert np.allclose(found.states[:, 1], expected, rtol=0.0, atol=1e-11)


@ways
def test_an_integrator_with_a_limit_goes_on_by_its_difference_equation(way: Way, close: float) -> None:
    """PI within +-2 V, sampled, with a delay; the integrator follows the limit."""
    gains = {"proportional": 12.0, "integral": 90.0, "tracking_time": 0.12, "limit": 2.0, "period": T, "delay": 0.3 * T}
    t = np.linspace(0.0, 1.5, 151)
    found = way(machine(loop(**gains)), t, [step(3.0, 0.1, before=0.2)])
    v, memory, held, expected = 0.0, 0.0, 0.0, []
    for k in range(len(t)):
        expected.append(v)
        error = (3.0 if k >= 10 else 0.2) - v
        asked = 12.0 * error + 90.0 * memory
        output = min(2.0, max(-2.0, asked))
        memory += T * (error + (output - asked) / (90.0 * 0.12))
        v, held = v + GAIN * T * (0.3 * held + 0.7 * output), output
    assert np.allclose(found.states[:, 1], expected, rtol=0.0, atol=close * 10)


def test_a_cascade_runs_from_the_outside_to_the_inside_at_every_sample() -> None:
    """The speed loop reads what the position loop asks for now, not a sample ago."""
    text = WHEEL + effect("position_loop", "wheel.motor", proportional=8.0, limit=1e6, period=T)
    text += effect("speed_loop", "wheel.motor", proportional=20.0, limit=1e6, period=T)
    t = np.linspace(0.0, 0.5, 51)
    found = simulate_affine(machine(text), t, [constant(1.0)])
    x, v, expected = 0.0, 0.0, []
    for _ in t:
        expected.append((x, v))
        a = GAIN * 20.0 * (8.0 * (1.0 - x) - v)
        x, v = x + T * v + 0.5 * T**2 * a, v + T * a
    assert np.allclose(found.states[:, :2], expected, rtol=0.0, atol=1e-11)


@ways
def test_friction_is_located_between_samples(way: Way, close: float) -> None:
    """The held voltage and friction stop the wheel at a time that is no sample's; weaker than friction, it stays."""
    text = loop(proportional=1.0, limit=1.0, period=0.3) + effect("coulomb_friction", "wheel.motor", level=0.5)
    t = np.linspace(0.0, 2.0, 21)
    found = way(machine(text), t, [constant(-50.0)], start=np.array([0.0, 2.0, 0.0]))
    stops = 2.0 * INERTIA / (0.5 + PER_VOLT)
    friction = [e for e in found.events if e.kind == "friction"]
    assert [(e.before, e.after) for e in friction] == [(1, 0)]
    assert friction[0].time == pytest.approx(stops, abs=close * 10)
    assert np.all(found.states[t > stops, 1] == 0.0)


def test_a_sample_that_sets_off_a_wheel_at_rest_is_an_event() -> None:
    text = loop(proportional=1.0, period=0.3) + effect("coulomb_friction", "wheel.motor", level=0.5)
    for way in (simulate_affine,):
        found = way(machine(text), np.linspace(0.0, 1.0, 11), [step(2.0, 0.4)])
        assert [(round(e.time, 9), e.before, e.after) for e in found.events] == [(0.6, 0, 1)]


def test_a_short_period_comes_to_the_continuous_loop() -> None:
    """With first order: a tenth of the period, a tenth of the difference."""
    t = np.linspace(0.0, 0.5, 26)

    def speed(text: str) -> Array:
        return simulate_affine(machine(text), t, [constant(1.0)]).states[:, 1]

    continuous = speed(loop(proportional=5.0, integral=10.0))
    far, near = (
        np.abs(speed(loop(proportional=5.0, integral=10.0, period=p)) - continuous).max() for p in (0.01, 0.001)
    )
    assert 0.0 < near < far < 0.1
    assert far / near == pytest.approx(10.0, rel=0.1)


@pytest.mark.slow
def test_the_seed_drive_with_a_sampled_servo_agrees_by_both_ways() -> None:
    text = load_robot("irb6-axis1").text.replace('S = "0 rad" ', 'S = "0.01 rad" ')
    sampled = machine(text + SERVO + 'period = "1 ms"\ndelay = "0.4 ms"\n')
    t = np.linspace(0.0, 0.3, 301)
    exact = simulate_affine(sampled, t, [step(1.0)])
    general = simulate_general(sampled, t, [step(1.0)], tolerance=1e-10)
    assert np.all(np.abs(general.states - exact.states).max(axis=0) < 1e-6 * np.abs(exact.states).max(axis=0))
    assert len(exact.events) > 5
    assert [(e.switch, e.after) for e in general.events] == [(e.switch, e.after) for e in exact.events]


def test_instants_are_whole_multiples_and_come_in_order() -> None:
    times, which = samples(np.array([[0.1, 0.1], [0.1, 0.0]]), 0.05, 0.3, closed=True)
    assert np.allclose(times, [0.1, 0.1, 0.2, 0.2, 0.3, 0.3], rtol=0.0, atol=1e-15)
    assert which.tolist() == [0, 1, 0, 1, 0, 1]  # what has waited for a period is let out before the next comes
    assert len(samples(np.array([[0.1, 0.0]]), 0.0, 0.3, closed=False)[0]) == 3
    assert len(samples(np.zeros((0, 2)), 0.0, 1.0, closed=True)[0]) == 0


def test_what_a_sampled_loop_cannot_be_is_refused() -> None:
    slow = robot_from_text(loop(proportional=1.0, period=T, delay=2 * T), "wheel.toml")
    with pytest.raises(InputError, match=r"SD452: .*0\.02 s, longer than their period"):
        compile_hybrid(slow)
    sampled = robot_from_text(loop(proportional=1.0, period=T), "wheel.toml")
    with pytest.raises(InputError, match=r"SD453: speed_loop at 'wheel\.motor' is sampled"):
        linearise(sampled)
    with pytest.raises(InputError, match="SD453"):
        compile_robot(sampled, smoothing=1e-3)
    with pytest.raises(InputError, match="SD203"):
        robot_from_text(loop(proportional=1.0, period=-T), "wheel.toml")


@pytest.mark.parametrize("gains", [{}, {"integral": 100.0}])
def test_a_loop_that_only_its_samples_make_unstable_is_refused(gains: dict[str, float]) -> None:
    """v_k+1 = (1 - GAIN K T) v_k: stable for T < 2 / 64 s; a weak integrator changes that little. Its place is told."""
    told = r"wheel.toml:\d+:\d+: SD455: speed_loop at 'wheel.motor' is stable without .* samples every 0.04 s: the mode"
    with pytest.raises(InputError, match=told):
        compile_hybrid(robot_from_text(loop(proportional=40.0, period=0.04, **gains), "wheel.toml"))
    if not gains:
        with pytest.raises(InputError, match=r"the mode of 64 rad/s that it makes .*\s+a period of 0.016 s is stable"):
            compile_hybrid(robot_from_text(loop(proportional=40.0, period=0.0314), "wheel.toml"))
    compile_hybrid(robot_from_text(loop(proportional=40.0, period=0.028, **gains), "wheel.toml"))


@pytest.mark.parametrize(("period", "stable"), [("1 ms", True), ("4 ms", True), ("64 ms", False)])
def test_the_seed_drive_is_sampled_by_what_its_servo_needs(period: str, stable: bool) -> None:
    """Its modes at 624 and 1261 Hz may pass between samples; the servo's own is one of 126 rad/s."""
    robot = robot_from_text(load_robot("irb6-axis1").text + SERVO + f'period = "{period}"\n', "drive.toml")
    if stable:
        compile_hybrid(robot)
    else:
        with pytest.raises(InputError, match=r"SD455: .* the mode of 12\d.* rad/s that it makes"):
            compile_hybrid(robot)


@pytest.mark.slow
@pytest.mark.parametrize("reports", [11, 30, 101])
def test_the_energy_of_a_sampled_drive_is_accounted_for(reports: int) -> None:
    """A PI loop with a delay, and friction that stops the wheel between samples; reports at samples and elsewhere."""
    gains = {"proportional": 3.0, "integral": 20.0, "limit": 4.0, "period": T, "delay": 0.3 * T}
    sampled = machine(
        MOTOR + effect("speed_loop", "wheel.motor", **gains) + effect("coulomb_friction", "wheel.motor", level=0.6)
    )
    signals = [step(0.0, 0.15, before=2.0)]
    trajectory = simulate_affine(sampled, np.linspace(0.0, 0.5, reports), signals)
    assert any(e.kind == "friction" and e.after == 0 for e in trajectory.events)
    assert energy_balance(sampled, trajectory, signals).closure < 1e-9


def test_a_batch_of_sampled_machines_gives_what_each_gives_alone() -> None:
    sampled, time = machine(loop(proportional=20.0, period=T)), np.linspace(0.0, 0.1, 11)
    place = next(k for k, p in enumerate(sampled.kernel.parameters) if p.endswith("proportional"))
    parameters = np.tile(sampled.kernel.values, (3, 1))
    parameters[:, place] = 10.0, 20.0, 30.0
    batch = simulate_batch(sampled, time, [constant(3.0)], parameters=parameters)
    assert batch.failures == ("",) * 3
    for k, p in enumerate(parameters):
        alone = simulate_affine(Machine(sampled.kernel, p), time, [constant(3.0)])
        assert np.array_equal(alone.states, batch.states[k])
        assert alone.steps == batch.steps[k]


def test_sensitivities_of_a_geometric_series() -> None:
    """v_k = r - (r - v_0) (1 - G K T)^k: by the gain K, and by the speed at the start."""
    gain, t = 20.0, np.linspace(0.0, 0.2, 21)
    sampled = machine(loop(proportional=gain, period=T))
    name = next(p for p in sampled.kernel.parameters if p.endswith("proportional"))
    found = simulate_sensitivities(
        sampled, t, [constant(3.0)], start=np.array([0.0, 0.5, 0.0]), parameters=[name], initial=True
    )
    k, q = np.arange(21), 1.0 - GAIN * gain * T
    by_gain = (3.0 - 0.5) * k * q ** np.maximum(k - 1, 0) * GAIN * T
    np.testing.assert_allclose(found.values[:, 1, 0], by_gain, rtol=1e-10, atol=1e-12)
    by_speed = found.values[:, 1, found.names.index("start of wheel.qd")]
    np.testing.assert_allclose(by_speed, q**k, rtol=1e-10, atol=1e-12)


@pytest.mark.slow  # a machine of its own, and two simulations for each parameter
@pytest.mark.parametrize("reports", [11, 31])
def test_sensitivities_across_samples_and_events_against_differences(reports: int) -> None:
    """A PI loop with a delay and a limit that is reached, friction that stops the wheel between samples."""
    gains = {"proportional": 3.0, "integral": 20.0, "limit": 4.0, "period": T, "delay": 0.3 * T}
    sampled = machine(
        MOTOR + effect("speed_loop", "wheel.motor", **gains) + effect("coulomb_friction", "wheel.motor", level=0.6)
    )
    kernel, time, signals = sampled.kernel, np.linspace(0.0, 0.5, reports), [step(0.0, 0.15, before=2.0)]
    start = np.array([0.0, 0.1, *np.zeros(sampled.size - 2)])
    timing = {k for k, p in enumerate(kernel.parameters) if p.endswith(("period", "delay"))}
    names = [p for k, p in enumerate(kernel.parameters) if k not in timing and kernel.values[k] != 0.0]
    found = simulate_sensitivities(sampled, time, signals, start=start, parameters=names)
    assert {(e.kind, e.after) for e in found.trajectory.events} >= {("friction", 0)}
    moved = 0
    for k, name in enumerate(names):
        h = np.zeros(len(kernel.values))
        place = kernel.parameters.index(name)
        h[place] = 1e-5 * kernel.values[place]
        ends = [simulate_affine(Machine(kernel, kernel.values + m * h), time, signals, start=start) for m in (1, -1)]
        expected = (ends[0].states - ends[1].states) / (2.0 * h[place])
        size = np.abs(expected).max(axis=0)
        moved += bool(np.any(size[1] > 0.0))
        assert np.all(np.abs(found.values[:, :, k] - expected).max(axis=0) <= 1e-5 * size + 1e-9), name
    assert moved >= 6


def test_a_parameter_that_moves_the_samples_is_refused() -> None:
    sampled = machine(loop(proportional=1.0, period=T))
    name = next(p for p in sampled.kernel.parameters if p.endswith("period"))
    with pytest.raises(InputError, match=rf"SD453: no sensitivity to {name}"):
        simulate_sensitivities(sampled, np.linspace(0.0, 0.1, 11), [constant(1.0)], parameters=[name])


MOTOR = WHEEL.replace("inductance = 0,", "inductance = 0.01,").replace(
    "back_emf_constant = 0 ", "back_emf_constant = 0.8 "
)


def test_a_cascade_of_three_loops_in_steady_state_asks_for_what_is_there() -> None:
    """Position, speed and current, each continuous: at the reference, and no current; on the way, the equations."""
    text = MOTOR + effect("position_loop", "wheel.motor", proportional=8.0, limit=1e6)
    text += effect("speed_loop", "wheel.motor", proportional=2.0, limit=1e6)
    text += effect("current_loop", "wheel.circuit", proportional=6.0, integral=900.0, scale=1.5, limit=1e6)
    t = np.linspace(0.0, 5.0, 51)
    states = simulate_affine(machine(text), t, [constant(1.0)]).states
    assert np.allclose(states[-1], [1.0, 0.0, 0.0, 0.0], rtol=0.0, atol=1e-6)

    def rate(_: float, z: Array) -> Array:
        x, v, current, memory = z
        missing = 1.5 * 2.0 * (8.0 * (1.0 - x) - v) - current
        voltage = 6.0 * missing + 900.0 * memory
        return np.array([v, 0.8 * current / INERTIA, (voltage - 2.0 * current - 0.8 * v) / 0.01, missing])

    expected = solve_ivp(rate, (0.0, 5.0), np.zeros(4), "DOP853", t_eval=t, rtol=1e-12, atol=1e-14).y.T
    assert np.all(np.abs(states - expected).max(axis=0) < 1e-9 * np.abs(expected).max(axis=0))


def test_a_sampled_current_loop_holds_its_voltage() -> None:
    """The wheel held by nothing but its inertia: between samples I and v follow two linear equations."""
    text = MOTOR + effect("current_loop", "wheel.circuit", proportional=1.5, limit=2.5, period=T)
    t = np.linspace(0.0, 0.2, 21)
    states = simulate_affine(machine(text), t, [constant(2.0)]).states
    held, transition = np.zeros(21), expm(T * np.array([[0.0, 0.8 / INERTIA, 0.0], [-80.0, -200.0, 100.0], [0.0] * 3]))
    v = current = 0.0
    for k in range(21):
        held[k] = min(2.5, max(-2.5, 1.5 * (2.0 - current)))
        assert states[k, 1:] == pytest.approx([v, current, held[k]], abs=1e-10)
        v, current, _ = transition @ [v, current, held[k]]
    assert held[0] == 2.5
    assert held[-1] < 2.0


def test_a_current_loop_around_a_motor_without_inductance_is_an_algebraic_loop() -> None:
    robot = robot_from_text(WHEEL + effect("current_loop", "wheel.circuit", proportional=3.0, limit=9.0), "wheel.toml")
    with pytest.raises(InputError, match=r"SD454: current_loop at 'wheel\.circuit' is an algebraic loop"):
        compile_hybrid(robot)
