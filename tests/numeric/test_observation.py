"""From a recording to motion and effort: derivatives against known ones, gaps, and what is not measured."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
import pytest
from scipy import signal

from symdyn.base.errors import InputError
from symdyn.compiler import compile_robot, load_robot
from symdyn.emit.kernel import Kernel
from symdyn.numeric.memory import driven_states
from symdyn.numeric.observation import derivative, low_pass, measured_effort, motion_cutoff, observe, slope_gain
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Robot, Side

from .pendulum import TOML, motion, pendulum, record, recording

RATE = 500.0
TIME = np.arange(5000) / RATE
INNER = slice(250, -250)  # half a second at either end: transients of the filter


@pytest.fixture(scope="module")
def robot() -> Robot:
    return pendulum()


@pytest.fixture(scope="module")
def kernel(robot: Robot) -> Kernel:
    return compile_robot(robot).kernel()


def test_derivatives_are_those_of_the_motion(robot: Robot, kernel: Kernel) -> None:
    q, v, a = motion(1, TIME)
    seen = observe(robot, kernel, recording(TIME, q, 0 * q), cutoff=40.0)
    for found, truth, size in ((seen.q, q, 1e-5), (seen.qd, v, 1e-4), (seen.qdd, a, 1e-3)):
        np.testing.assert_allclose(found[INNER, 0], truth[INNER], atol=size * np.ptp(truth))


def test_derivatives_are_exact_for_polynomials_of_degree_four_on_a_clock_that_trembles() -> None:
    time = np.cumsum(0.01 * (1.0 + 0.3 * np.random.default_rng(0).uniform(-1.0, 1.0, 400)))
    found = derivative(np.stack([time**4, time], axis=1), time)
    np.testing.assert_allclose(found[2:-2], np.stack([4.0 * time**3, np.ones_like(time)], axis=1)[2:-2], atol=1e-9)
    assert derivative(time[:3] ** 2, time[:3]).shape == (3,)  # too few for five


@pytest.mark.parametrize("turn", [0.1, 0.25, 0.5])
def test_quick_motions_in_a_wide_band_are_as_large_as_they_are(robot: Robot, kernel: Kernel, turn: float) -> None:
    """Up to a twelfth of the rate; over three samples it would be 0.2, 1 and 4 % small."""
    q = np.sin(turn * RATE * TIME)
    seen = observe(robot, kernel, recording(TIME, q, 0 * q), cutoff=1e9)
    assert -seen.qdd[INNER, 0] @ q[INNER] / (q[INNER] @ q[INNER]) / (turn * RATE) ** 2 == pytest.approx(1.0, abs=5e-3)
    assert slope_gain(np.array([turn]))[0] == pytest.approx(1.0 - turn**4 / 30.0, abs=2e-4)


def test_encoder_noise_is_kept_out_of_the_acceleration(robot: Robot, kernel: Kernel) -> None:
    q, _, a = motion(1, TIME)
    noisy = recording(TIME, q + 5e-6 * np.random.default_rng(2).standard_normal(len(q)), 0 * q)
    found, everything = (observe(robot, kernel, noisy, cutoff) for cutoff in (None, 1e9))
    assert 1.1 < found.cutoff < 30.0  # the fastest part of the motion, 1.1 Hz, is in
    quiet, loud = (np.std((seen.qdd[:, 0] - a)[INNER]) for seen in (found, everything))
    assert quiet < 0.02 * np.std(a)
    assert loud > 20 * quiet


def swept(highest: float, noise: float) -> np.ndarray:
    """(N,) a sweep from rest to ``highest`` Hz, whose size falls with frequency, and an encoder's noise."""
    phase = np.pi * highest * TIME**2 / TIME[-1]
    return np.sin(phase) / (1.0 + 0.2 * highest * TIME) + noise * np.random.default_rng(3).standard_normal(len(TIME))


def test_cutoff_follows_the_fastest_motion_that_shows() -> None:
    whole = (slice(0, len(TIME)),)
    clear = {hertz: motion_cutoff(swept(hertz, 1e-6)[:, None], whole, RATE) for hertz in (2.0, 10.0, 40.0)}
    for hertz, cutoff in clear.items():
        assert 0.8 * hertz < cutoff < 2 * hertz + 6
    drowned = motion_cutoff(swept(40.0, 0.1)[:, None], whole, RATE)
    assert drowned < 0.6 * clear[40.0]
    slow_and_fast = np.column_stack([swept(2.0, 1e-6), swept(40.0, 1e-6)])
    assert motion_cutoff(slow_and_fast, whole, RATE) == clear[40.0]  # the fastest joint counts


def test_low_pass_keeps_phase_and_halves_the_power_twice_at_its_edge() -> None:
    """Butterworth run forwards and backwards: magnitude 1/2 at the cutoff, no lag."""
    edge = np.sin(2 * np.pi * 10.0 * TIME)
    np.testing.assert_allclose(low_pass(edge, RATE, 10.0)[INNER], 0.5 * edge[INNER], atol=2e-3)
    assert low_pass(edge, RATE, 0.4 * RATE) is edge
    constant = np.full(300, 3.0)
    np.testing.assert_allclose(low_pass(constant, RATE, 5.0), constant, rtol=1e-9)


@pytest.mark.parametrize("shape", [(400,), (400, 3), (400, 3, 2), (9, 2), (1, 2)])
def test_low_pass_is_that_of_scipy(shape: tuple[int, ...]) -> None:
    values = np.random.default_rng(0).standard_normal(shape) + 3.0
    sections = signal.butter(4, 20.0, fs=RATE, output="sos")
    expected = signal.sosfiltfilt(sections, values, axis=0, padlen=min(len(values) - 1, 75))
    np.testing.assert_allclose(low_pass(values, RATE, 20.0), expected, rtol=0, atol=1e-12)


def test_a_jump_across_a_gap_is_no_motion(robot: Robot, kernel: Kernel) -> None:
    q, v, _ = motion(1, TIME)
    q[2500:] += 3.0  # moved by hand in between
    time = TIME + 10.0 * (np.arange(len(TIME)) >= 2500)
    parts = (slice(0, 2500), slice(2500, 5000))
    seen = observe(robot, kernel, recording(time, q, 0 * q, parts=parts), cutoff=40.0)
    assert np.max(np.abs(seen.qd[:, 0] - v)) < 0.2
    joined = observe(robot, kernel, recording(TIME, q, 0 * q), cutoff=40.0)
    assert np.max(np.abs(joined.qd[:, 0] - v)) > 100.0


def test_measured_effort_is_taken_as_it_is(robot: Robot, kernel: Kernel) -> None:
    run = record(1)
    found = measured_effort(robot, kernel, run)
    assert np.array_equal(found[:, 0], run.channel(Quantity.EFFORT, "arm"))


@pytest.mark.parametrize(("unit", "quantity"), [("V", Quantity.VOLTAGE), ("A", Quantity.CURRENT)])
def test_effort_follows_from_the_input_of_the_actuator(unit: str, quantity: Quantity) -> None:
    driven = pendulum(TOML.replace('zz = "I" } }', f'zz = "I" }} }}\nactuator = {{ gain = "0.7 N m/{unit}" }}'))
    full = record(1)
    drive = np.cos(TIME)
    channels = {(Quantity.POSITION, "arm", Side.LINK): np.sin(TIME), (quantity, "arm", Side.MOTOR): drive}
    run = Recording("run", TIME, MappingProxyType(channels), 1 / RATE, (slice(0, len(TIME)),), (), full.sha256)
    found = measured_effort(driven, compile_robot(driven).kernel(), run)
    np.testing.assert_allclose(found[:, 0], 0.7 * drive, rtol=1e-14)
    both = Recording(
        "run",
        TIME,
        MappingProxyType({**channels, (Quantity.EFFORT, "arm", Side.LINK): 9.0 + drive}),
        1 / RATE,
        run.segments,
        (),
        full.sha256,
    )
    measured = measured_effort(driven, compile_robot(driven).kernel(), both)
    assert np.array_equal(measured[:, 0], 9.0 + drive)  # a measured effort needs no gain


def test_position_or_effort_that_is_missing_is_asked_for(robot: Robot, kernel: Kernel) -> None:
    full = record(1)
    for left_out, code in ((Quantity.EFFORT, "SD520"), (Quantity.POSITION, "SD510")):
        channels = MappingProxyType({key: values for key, values in full.channels.items() if key[0] is not left_out})
        run = Recording("run", full.time, channels, full.sample_time, full.segments, (), full.sha256)
        with pytest.raises(InputError, match=f"no {left_out}") as caught:
            observe(robot, kernel, run)
        assert [problem.code for problem in caught.value.problems] == [code]


def test_states_that_nobody_measures_are_refused() -> None:
    drive = load_robot("irb6-axis1")
    with pytest.raises(InputError, match=r"axis1\.motor\.current") as caught:
        observe(drive, compile_robot(drive).kernel(), record(1))
    assert [problem.code for problem in caught.value.problems] == ["SD521"]


def test_friction_that_remembers_follows_from_the_motion() -> None:
    friction = '[[effect]]\ntype = "dahl_friction"\nat = "arm"\nstiffness = 40\nlevel = 2\n'
    lasting = pendulum(TOML.replace("[recording]", f"{friction}\n[recording]"))
    assert driven_states(lasting) == {"arm.elastic_deflection"}
    assert observe(lasting, compile_robot(lasting).kernel(), record(1)).q.shape == (10_000, 1)
