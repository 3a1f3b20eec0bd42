"""The analysis band: found where the mismatch is, filtered without phase, segments kept apart."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.numeric.band import SAMPLES_PER_PERIOD, Band, analysis_band, band_of, sound
from symdyn.numeric.observation import Observation

Array = NDArray[np.float64]

RATE = 500.0
TIME = np.arange(5000) / RATE


def seen(cutoff: float = 200.0, segments: tuple[slice, ...] = (slice(0, len(TIME)),)) -> Observation:
    nothing = np.zeros((len(TIME), 1))
    return Observation(TIME, nothing, nothing, nothing, nothing, segments, 1.0 / RATE, cutoff, nothing, np.zeros(1))


def wave(hertz: float, size: float = 1.0) -> Array:
    return size * np.sin(2 * np.pi * hertz * TIME)[:, None]


def noise(size: float) -> Array:
    return size * np.random.default_rng(1).standard_normal((len(TIME), 1))


def test_what_lies_within_the_band_passes_and_what_lies_above_does_not() -> None:
    band = band_of(10.0, RATE)
    times = band.bring(TIME[:, None], seen())[:, 0]
    low, high = (band.bring(wave(f), seen())[:, 0] for f in (3.0, 30.0))
    np.testing.assert_allclose(low, np.sin(2 * np.pi * 3.0 * times), atol=2e-3)  # same phase, same size
    assert np.max(np.abs(high)) < 0.03  # what is left of the filter's transients at the ends
    assert np.max(np.abs(high[len(high) // 4 : -len(high) // 4])) < 2e-4  # 3^-8 of it passes


def test_samples_are_kept_as_densely_as_the_band_needs() -> None:
    for cutoff in (5.0, 12.5, 40.0):
        band = band_of(cutoff, RATE)
        times = band.bring(TIME[:, None], seen())[:, 0]
        steps = np.diff(times) * cutoff
        assert np.all(steps <= 1.0 / SAMPLES_PER_PERIOD + 1e-4)
        assert np.all(steps > 0.5 / SAMPLES_PER_PERIOD)


def test_band_never_reaches_beyond_what_is_sampled() -> None:
    band = band_of(1e9, RATE)
    assert band == Band(0.4 * RATE, 1)
    assert np.array_equal(band.bring(noise(1.0), seen()), noise(1.0)[2:-2])  # nothing cut but the ends


def test_trailing_axes_are_filtered_alike() -> None:
    band = band_of(10.0, RATE)
    stack = np.stack([wave(1.0), wave(4.0) + 2.0], axis=2)
    brought = band.bring(stack, seen())
    assert brought.shape[1:] == (1, 2)
    for k in range(2):
        np.testing.assert_allclose(brought[:, :, k], band.bring(stack[:, :, k], seen()), rtol=1e-12)


def test_segments_do_not_reach_into_each_other() -> None:
    """What lies beyond a gap changes nothing, however large; a segment that is all transient is dropped."""
    parts = (slice(0, 2000), slice(2000, 2040), slice(2040, 5000))
    band = band_of(10.0, RATE)
    plain = wave(2.0)
    disturbed = plain.copy()
    disturbed[2000:2040] = 1e6
    disturbed[2040:] += 50.0
    before, after = (band.bring(values, seen(segments=parts)) for values in (plain, disturbed))
    first = len(range(2000)[50:-50:12])
    assert len(before) == first + len(range(2960)[50:-50:12])
    np.testing.assert_allclose(after[:first], before[:first], atol=1e-12)
    np.testing.assert_allclose(after[first:], before[first:] + 50.0, atol=1e-9)


def test_ends_where_the_positions_filter_has_not_settled_are_left_out() -> None:
    spoilt = wave(2.0)
    spoilt[:30], spoilt[-30:] = 1e3, -1e3  # three periods of 50 Hz
    band = band_of(10.0, RATE)
    np.testing.assert_array_equal(band.bring(spoilt, seen(50.0)), band.bring(wave(2.0), seen(50.0)))
    short = (slice(0, 4000), slice(4000, 4160))
    assert [part.stop - part.start for part in sound(seen(5.0, short))] == [4000 - 2 * 300, 160 - 2 * 20]


@pytest.mark.parametrize("hertz", [5.0, 12.0, 30.0])
def test_band_holds_the_mismatch_twice_over(hertz: float) -> None:
    found = analysis_band(wave(hertz) + noise(0.05), seen())
    assert 2 * hertz <= found.cutoff <= 2 * hertz + 4 * RATE / 625  # the spectrum's resolution, twice


def test_noise_does_not_widen_the_band() -> None:
    quiet, loud = (analysis_band(wave(8.0) + noise(size), seen()).cutoff for size in (0.01, 0.2))
    assert loud <= quiet + 2 * RATE / 625


def test_band_ends_where_positions_sink_into_their_noise() -> None:
    residual = wave(2.0) + wave(40.0)
    assert analysis_band(residual, seen(cutoff=200.0)).cutoff > 75.0
    assert analysis_band(residual, seen(cutoff=15.0)).cutoff < 15.0


def test_widest_of_the_joints_counts() -> None:
    both = np.column_stack([wave(3.0), wave(20.0)])
    assert analysis_band(both, seen()).cutoff == analysis_band(both[:, ::-1], seen()).cutoff >= 40.0
