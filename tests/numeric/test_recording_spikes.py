"""Samples that a bus got wrong are found and mended; what a machine does is left alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symdyn.base.errors import Where
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.recording_quality import steps_of
from symdyn.numeric.recording_spikes import without_spikes
from symdyn.spec.records import Channel, Quantity, Side

from .pendulum import pendulum
from .test_recording_repeats import TIME, Array, read, turning

WHOLE = (slice(0, len(TIME)),)
HERE = Where("run.csv", 1, 2)


def channel(quantity: Quantity, unit: str) -> Channel:
    return Channel("x", quantity, "arm", Side.LINK, unit, 1.0)


def spikes(seed: int, count: int = 5) -> Array:
    return np.random.default_rng(seed).choice(len(TIME) - 100, count, replace=False) + 50


@pytest.mark.parametrize("size", [0.05, 4.0])
def test_spikes_are_replaced_by_what_is_around_them(size: float) -> None:
    q = turning(1, amplitude=1.2)[0]
    shown, at = q.copy(), spikes(3)
    shown[at] += size
    mended, (problem,) = without_spikes(channel(Quantity.POSITION, "rad"), shown, WHOLE, HERE)
    assert problem.code == "SD534"
    assert problem.message.startswith("5 samples of 'x' stand alone")
    assert mended == pytest.approx(q, abs=1e-3)
    assert np.all(mended[np.setdiff1d(np.arange(len(q)), at)] == q[np.setdiff1d(np.arange(len(q)), at)])


def test_what_replaces_them_is_one_of_the_sensors_steps() -> None:
    size = 2.0 * np.pi / 512
    q = size * np.round(turning(1, amplitude=1.2)[0] / size)
    shown = q.copy()
    shown[spikes(3)] += 1.7
    mended, _ = without_spikes(channel(Quantity.POSITION, "rad"), shown, WHOLE, HERE)
    assert np.all(np.isin(mended, q))
    assert mended == pytest.approx(q, abs=1.01 * size)
    found = steps_of(mended)
    assert found is not None
    assert found[0] == pytest.approx(size, rel=1e-6)


@pytest.mark.parametrize(
    "signal",
    [
        np.sign(np.sin(3.0 * TIME)),  # dry friction, without any noise
        np.round(np.sin(3.0 * TIME), 2),  # coarse steps
        np.sin(3.0 * TIME) + 0.01 * np.random.default_rng(1).standard_normal(len(TIME)),
        np.sin(3.0 * TIME) + 0.5 * np.exp(-((np.mod(TIME, 2.0) / 0.01) ** 2)),  # an impact of some samples
        np.random.default_rng(2).standard_t(5, len(TIME)),  # noise with long tails
        np.zeros(len(TIME)),
    ],
)
def test_what_a_machine_does_is_no_spike(signal: Array) -> None:
    for quantity in (Quantity.EFFORT, Quantity.VELOCITY):
        kept, problems = without_spikes(channel(quantity, "N m"), signal, WHOLE, HERE)
        assert problems == []
        assert kept is signal


def test_a_voltage_may_jump(tmp_path: Path) -> None:
    pulses = np.zeros(len(TIME))
    pulses[spikes(1)] = 24.0
    pulses += np.sin(TIME)
    assert without_spikes(channel(Quantity.VOLTAGE, "V"), pulses, WHOLE, HERE)[1] == []


@pytest.mark.slow  # a whole diagnosis
def test_lost_samples_are_no_physics(tmp_path: Path) -> None:
    runs = []
    for seed in (1, 2):
        q, tau = turning(seed, dry=0.3, amplitude=1.2)
        q[spikes(seed)] = tau[spikes(seed)] = 0.0
        tau[spikes(seed + 10)] += 40.0
        runs.append(read(tmp_path, q, tau))
        assert [problem.code for problem in runs[-1].warnings] == ["SD534", "SD534"]
    told = diagnose(pendulum(), *runs)
    assert [finding.effect for finding in told.findings] == ["coulomb_friction"]
    assert not told.remaining.structured
    assert sum("stand alone" in alarm for alarm in told.alarms) == 4  # two channels of two runs
