"""Efforts that are late against the motion: told as such, and not as physics."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest

from symdyn.base.errors import BadRecording
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Verdict
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.recording import Recording
from symdyn.numeric.setting import prepare
from symdyn.numeric.skew import a_little_late, aligned, effort_skew, skew_left
from symdyn.spec.records import Quantity

from .pendulum import ARM, MASS, VISCOUS, Torque, pendulum, record

STEP = 1 / 500.0


def late(seed: int, samples: int, missing: Torque | None = None) -> Recording:
    """A run whose effort channel lags by that many samples; the ends that have no partner are cut off."""
    run = record(seed, missing)
    kept = slice(samples, len(run.time))
    channels = {
        key: values[: len(values) - samples] if key[0] is Quantity.EFFORT else values[kept]
        for key, values in run.channels.items()
    }
    time = run.time[kept]
    return replace(run, time=time, channels=MappingProxyType(channels), segments=(slice(0, len(time)),))


@pytest.mark.parametrize("samples", [pytest.param(2, marks=pytest.mark.slow), 10])
def test_late_effort_of_a_complete_model_is_a_bad_recording(samples: int) -> None:
    with pytest.raises(BadRecording) as caught:
        diagnose(pendulum(), late(1, samples), late(101, samples))
    (problem,) = caught.value.problems
    assert problem.code == "SD529"
    told = float(problem.message.split()[1])
    assert told == pytest.approx(samples * STEP, rel=0.03)
    assert "late" in problem.message


@pytest.mark.slow
def test_late_effort_beside_friction_is_told_and_the_friction_kept() -> None:
    def friction(t: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        return 0.3 * np.sign(v)

    found = diagnose(pendulum(), late(1, 5, friction), late(101, 5, friction))
    assert [f.effect for f in found.findings] == ["coulomb_friction", "channel_skew"]
    (level, delay) = (next(iter(f.parameters.values())) for f in found.findings)
    assert level.se is not None
    assert delay.se is not None
    # Each is fitted beside the other: before that, a law that looks like lateness kept some of it.
    assert abs(level.value - 0.3) < 4.0 * level.se < 0.01
    assert abs(delay.value - 5 * STEP) < 4.0 * delay.se < 0.0005
    assert found.verdict is Verdict.MISSING_PHYSICS
    (alarm,) = [alarm for alarm in found.alarms if "late against the motion" in alarm]
    assert float(alarm.split()[1]) == pytest.approx(5 * STEP, rel=0.03)


def acting_late(seed: int, samples: int, noise: float, missing: Torque) -> Recording:
    """A run whose efforts act that many samples after they are recorded, under noise besides the sensor's own."""
    run = record(seed, missing)
    rng = np.random.default_rng([seed, 5])
    count = len(run.time) - samples
    channels = {
        key: values[samples:] + noise * rng.standard_normal(count) if key[0] is Quantity.EFFORT else values[:count]
        for key, values in run.channels.items()
    }
    shown = replace(run, time=run.time[:count], channels=MappingProxyType(channels))
    return replace(shown, segments=(slice(0, count),))


@pytest.mark.slow  # a whole diagnosis
def test_efforts_that_act_late_are_told_though_that_is_little_of_what_is_left() -> None:
    """Gravity and viscous friction took up some of it: all is fitted anew."""

    def friction(t: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        return 0.3 * np.sign(v)

    found = diagnose(pendulum(), *(acting_late(seed, 3, 0.3, friction) for seed in (1, 101)))
    assert [f.effect for f in found.findings] == ["coulomb_friction", "channel_skew"]
    assert found.verdict is Verdict.MISSING_PHYSICS
    told = [next(iter(f.parameters.values())) for f in found.findings]
    for estimate, truth in zip((*told, found.model["b"]), (0.3, -3 * STEP, VISCOUS), strict=True):
        assert estimate.se is not None
        assert abs(estimate.value - truth) < 3.0 * estimate.se < 0.3 * abs(truth)
    assert found.model["m"].value * found.model["r"].value == pytest.approx(MASS * ARM, rel=0.004)


@pytest.mark.slow  # a whole diagnosis
def test_what_is_unknown_is_not_told_as_late_efforts() -> None:
    """It is a little like them, and a skew beside it goes on leaving something."""

    def resisting(t: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        return 0.3 * np.sign(v) - 0.0015 * np.gradient(a, t) * v**2

    found = diagnose(pendulum(), *(acting_late(seed, 0, 0.02, resisting) for seed in (1, 101)))
    assert found.verdict is Verdict.UNEXPLAINED
    assert "channel_skew" not in [f.effect for f in found.findings]
    assert any("would tell" in alarm for alarm in found.alarms)


def held(seed: int) -> Recording:
    """Efforts as a controller that holds them over a sample logs them: half a sample early, under much noise."""
    run = record(seed, duration=60.0, rate=2.0 / STEP)
    rng = np.random.default_rng([seed, 3])
    channels = {
        key: values[1::2] + 0.11 * rng.standard_normal(len(values) // 2) if key[0] is Quantity.EFFORT else values[::2]
        for key, values in run.channels.items()
    }
    time = run.time[::2]
    shown = replace(run, time=time, sample_time=STEP, channels=MappingProxyType(channels))
    return replace(shown, segments=(slice(0, len(time)),))


def test_half_a_sample_is_a_little_late_though_it_tells_little() -> None:
    """Masses and gravity are told from what it leaves, long before anything in a residual tells of it."""
    setting = prepare(pendulum(), held(1), held(101), lambda _: None)
    case = setting.case(5.0)
    given = case.explain()
    skew = effort_skew(case, given)
    assert skew.delay == pytest.approx(-0.5 * STEP, abs=3.0 * skew.se)
    assert skew_left(case, given) is None
    assert a_little_late(case, given)
    assert not a_little_late(case, aligned(Inquiry(setting, case, given, setting, case, given)).current)
