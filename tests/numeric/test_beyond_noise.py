"""What is left beside the noise of sensors: told apart from it, though it be quick and follow nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal

from symdyn.compiler import parametric_kernel
from symdyn.numeric.beyond_noise import beyond_noise
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Verdict
from symdyn.numeric.setting import prepare
from symdyn.numeric.workbench import Workbench
from symdyn.spec.records import Robot

from .pendulum import ARM, GRAVITY, MASS, TORQUE_NOISE, TURNING, VISCOUS, Torque, motion, pendulum, record

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def robot() -> Robot:
    return pendulum()


def coloured(time: Array, q: Array, v: Array, a: Array) -> Array:
    """Noise of a sensor that filters at 15 Hz: twenty times what it has at higher frequencies."""
    white = np.random.default_rng(int(abs(q[0]) * 1e6)).standard_normal(len(time))
    return 10.0 * TORQUE_NOISE * signal.lfilter(*signal.butter(1, 15.0, fs=500.0), white)


def detents(time: Array, q: Array, v: Array, a: Array) -> Array:
    """Waves of 0.05 rad around one angle: no ripple, and too many for a coarse curve."""
    return 0.3 * np.sin(2.0 * np.pi * q / 0.05) * np.exp(-(((q + 0.5) / 0.2) ** 2))


def hum(time: Array, q: Array, v: Array, a: Array) -> Array:
    return 0.2 * np.sin(2.0 * np.pi * 4.3 * time)


def whine(time: Array, q: Array, v: Array, a: Array) -> Array:
    return 0.2 * np.sin(2.0 * np.pi * 9.3 * time)


@pytest.mark.parametrize("band", [4.0, 15.0])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_noise_is_accounted_for(robot: Robot, seed: int, band: float) -> None:
    case = prepare(robot, record(seed), record(seed + 10), lambda _: None).case(band)
    explained = case.explain()
    (found,) = beyond_noise(case.judge, explained.fit.p, explained.heldout, np.zeros(1))
    assert found.times == pytest.approx(1.0, abs=0.25)
    assert found.p_value > 0.99
    assert found.line > 0.01


def test_noise_of_positions_is_accounted_for_where_there_is_no_other(robot: Robot) -> None:
    """The residual of a true model, of which the encoder's noise is all that is wrong."""
    bench = prepare(robot, record(1), record(2), lambda _: None).case(10.0).bench
    o, p = bench.observation, parametric_kernel(robot).values
    q, v, a = motion(1, o.time)
    exact = replace(o, tau=(TURNING * a + VISCOUS * v + MASS * GRAVITY * ARM * np.cos(q))[:, None])
    quiet = Workbench(bench.kernel, exact, bench.band)
    (found,) = beyond_noise(quiet, p, quiet.residual(p), np.zeros(1))
    assert found.times == pytest.approx(1.0, abs=0.25)


@pytest.mark.slow  # whole diagnoses
@pytest.mark.parametrize(("missing", "nearest"), [(detents, {"torque_ripple"}), (hum, set())])
def test_what_is_more_than_noise_is_unexplained(robot: Robot, missing: Torque, nearest: set[str]) -> None:
    told = diagnose(robot, record(1, missing), record(2, missing))
    assert told.verdict is Verdict.UNEXPLAINED
    assert {finding.effect for finding in told.findings} == nearest
    assert told.remaining.unlike_noise > 0.3


def test_what_is_quicker_than_the_motion_is_noted(robot: Robot) -> None:
    told = diagnose(robot, record(1, whine), record(2, whine))
    assert told.verdict is Verdict.COMPLETE
    assert any("nothing known tells what is quicker" in alarm for alarm in told.alarms)


def test_what_is_as_even_as_noise_is_noted(robot: Robot) -> None:
    told = diagnose(robot, record(1, coloured), record(2, coloured))
    assert (told.verdict, told.findings) == (Verdict.COMPLETE, ())
    (note,) = [alarm for alarm in told.alarms if "filters its noise" in alarm]
    assert "what is left at arm is" in note


@pytest.mark.slow
def test_where_nothing_pointed_before_what_is_left_does(robot: Robot) -> None:
    told = diagnose(robot, record(1, detents), record(2, detents))
    assert [place.place for place in told.located] == ["arm"]
    assert told.located[0].evidence > 0.0
