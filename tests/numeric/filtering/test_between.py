"""Inputs between samples: lines that have a band-limited signal's spectrum, and a mass that is told by them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric.filtering.between import Between, matters, nodes
from symdyn.numeric.filtering.explain import sampled
from symdyn.numeric.filtering.judged import explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import prepare, without_latent
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot
from tests.numeric.filtering.oscillator import DAMPING, MASS, MODEL, RATE, SPRING

COUNT, FINE = 2000, 32


def sine(share: float) -> np.ndarray:
    """At that share of half the sampling rate."""
    return np.sin(np.pi * share * np.arange(COUNT) + 0.3)[:, None]


def even(count: int = COUNT) -> np.ndarray:
    return np.append(np.full(count - 1, 1e-3), np.nan)


def amplitude(values: np.ndarray, share: float) -> float:
    """Of what straight lines between values have at a frequency, in the middle of the recording."""
    at = np.arange(0.0, COUNT - 1, 1.0 / FINE)
    middle = (at > 200) & (at < 1800)
    wave = np.exp(-1j * np.pi * share * at[middle])
    window = np.hanning(int(middle.sum()))
    lines = np.interp(at, np.arange(COUNT), values[:, 0])[middle]
    return 2.0 * float(np.abs(np.sum(window * wave * lines)) / window.sum())


@pytest.mark.parametrize("share", [0.02, 0.2, 0.4, 0.8])
def test_lines_have_the_spectrum_of_the_signal(share: float) -> None:
    u = sine(share)
    assert amplitude(u, share) == pytest.approx(np.sinc(0.5 * share) ** 2, abs=1e-3)
    assert amplitude(nodes(u, even()), share) == pytest.approx(1.0, abs=2e-3)


def test_a_constant_stays_and_runs_do_not_reach_into_one_another() -> None:
    u = np.concatenate([np.full((100, 1), 2.0), np.full((80, 1), -1.0)])
    steps = even(180)
    steps[99] = np.nan
    np.testing.assert_allclose(nodes(u, steps), u, rtol=1e-12)
    assert not np.allclose(nodes(u, even(180)), u, rtol=1e-3)


def test_it_matters_where_an_input_is_quick_for_its_samples() -> None:
    assert not matters(sine(0.05), even())
    assert matters(sine(0.4), even())
    uneven = even()
    uneven[7] *= 1.01
    assert not matters(sine(0.4), uneven)
    assert not matters(np.zeros((COUNT, 1)), even())


def record(path: Path, robot: Robot, seed: int) -> Recording:
    """Steady state of a linear oscillator under waves up to 150 Hz, in closed form: nothing is held, or straight."""
    random = np.random.default_rng(seed)
    hertz = np.arange(2, 401) * RATE / COUNT
    phases = 2.0 * np.pi * random.random(len(hertz))
    time = np.arange(COUNT) / RATE
    waves = 3.0 * np.exp(1j * (2.0 * np.pi * np.outer(time, hertz) + phases))
    omega = 2.0 * np.pi * hertz
    motion = waves / (SPRING + 1j * omega * DAMPING - MASS * omega**2)
    seen = motion.sum(axis=1).real + 2e-6 * random.standard_normal(COUNT)
    rows = np.column_stack([time, waves.sum(axis=1).real, seen])
    np.savetxt(path, rows, delimiter=",", header="t,f,x", comments="", fmt="%.9g")
    return read_recording(path, robot.channels)


def test_a_mass_is_told_by_a_band_limited_force(tmp_path: Path) -> None:
    robot = robot_from_text(MODEL, "oscillator.toml")
    model = prepare(robot, *(record(tmp_path / f"{seed}.csv", robot, seed) for seed in (1, 2)), only=("",))
    bench = model.bench(model.training, without_latent(model, model.training), Between.STRAIGHT)
    straight = explained(model, (), model.beliefs, fit(bench, model.values, model.beliefs))
    banded = sampled(model, straight)
    assert banded.fit.bench.between is Between.BANDED
    off = []
    for each in (straight.fit, banded.fit):
        i = each.names.index("m")
        off.append(abs(each.p[each.bench.index["m"]] - MASS) / np.sqrt(each.covariance[i, i]))
    assert banded.fit.loss < straight.fit.loss - 1000.0
    assert off[1] < 3.0 < off[0]
    assert sampled(model, banded) is banded
