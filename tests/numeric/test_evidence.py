"""Evidence: against closed forms on white noise, and not fooled by samples that say the same twice."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.numeric.evidence import coloured_gain, effective_count, gaussian_gain

COUNT = 4000


def white(seed: int, count: int = COUNT) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(count)


def test_gain_of_white_noise_is_that_of_the_likelihood() -> None:
    after = white(0)[:, None]
    assert gaussian_gain(3.0 * after, after, COUNT) == pytest.approx(COUNT * np.log(3.0), rel=0.05)
    assert gaussian_gain(after, after, COUNT) == 0.0
    assert gaussian_gain(after, 3.0 * after, COUNT) < 0.0


def test_joints_add_up() -> None:
    after = np.stack([white(1), 5.0 * white(2)], axis=1)
    both = gaussian_gain(2.0 * after, after, COUNT)
    assert both == pytest.approx(sum(gaussian_gain(2.0 * after[:, [j]], after[:, [j]], COUNT) for j in (0, 1)))


@pytest.mark.parametrize("repeats", [4, 20])
def test_samples_that_repeat_count_once(repeats: int) -> None:
    count = effective_count(np.repeat(white(3, 1000), repeats), np.inf)
    assert 700 < count < 2200  # Bartlett's weights see at least half of the correlation


def test_never_more_than_the_band_holds() -> None:
    rising = np.diff(white(4))  # differentiated: its long-run variance is zero
    assert effective_count(rising, 500.0) == 500.0


def lowpassed(seed: int, length: int, count: int = COUNT) -> np.ndarray:
    return np.convolve(white(seed, count + length), np.ones(length) / np.sqrt(length), mode="valid")[:count]


def test_slow_force_beneath_noise_has_evidence_of_its_size() -> None:
    gains = []
    for size in (0.0, 0.3, 1.0, 3.0):
        training, heldout = (white(s) + size * lowpassed(s + 50, 40) for s in (5, 6))
        gains.append(coloured_gain(training, heldout, 2.0))
    assert gains[0] < 5.0
    assert gains == sorted(gains)
    assert gains[1] > 10.0


@pytest.mark.parametrize("seed", range(10))
def test_noise_alone_has_none_even_where_it_was_differentiated(seed: int) -> None:
    for make in (white, lambda s: np.diff(white(s), append=0.0)):
        assert coloured_gain(make(seed), make(seed + 100), 2.0) < 5.0


def test_idle_or_short_residuals_have_none() -> None:
    assert coloured_gain(np.zeros(COUNT), np.zeros(COUNT), 2.0) == 0.0
    assert coloured_gain(white(1, 10), white(2, 10), 2.0) == 0.0
