"""Spectra of measured positions: up to where they show motion, and how much they tremble beyond."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Array = NDArray[np.float64]

FLOOR_MARGIN = 10.0  # a position spectrum this far above its noise floor is taken for motion
WHOLE = 0.4  # of the rate: motion beyond is not looked for, and a filter whose edge is there takes nothing


def motion_cutoff(positions: Array, segments: Sequence[slice], rate: float) -> float:
    """Frequency (Hz) below which a position's spectrum stands above its own noise floor without a gap."""
    longest = max(segments, key=lambda part: part.stop - part.start)
    cutoff = 0.0
    for column in positions[longest].T:
        frequency, power = _spectrum(column, rate)
        floor = np.median(power[len(power) // 2 :])
        quiet = np.flatnonzero(_level(power) <= FLOOR_MARGIN * floor)
        cutoff = max(cutoff, float(frequency[quiet[0]] if len(quiet) else frequency[-1]))
    return float(np.clip(cutoff, rate / 1000.0, WHOLE * rate))


def spectrum(position: Array, rate: float) -> tuple[Array, Array]:
    """Frequencies (Hz) and power density of a position (N,), smoothed over neighbours."""
    frequency, power = _spectrum(position, rate)
    return frequency, _level(power)


def _spectrum(position: Array, rate: float) -> tuple[Array, Array]:
    """It is taken of second differences and divided by theirs: the slow, large part of the motion would otherwise leak
    over everything else.
    """
    bend = np.diff(position, 2)
    frequency, power = signal.welch(bend, rate, nperseg=max(64, min(len(bend), 4096) // 2))
    return frequency[1:], power[1:] / (2.0 * np.sin(np.pi * frequency[1:] / rate)) ** 4


def _level(power: Array) -> Array:
    """A single bin of noise exceeds any margin now and then."""
    return np.convolve(power, np.ones(5) / 5.0, mode="same")


def floor(positions: Array, segments: Sequence[slice], rate: float) -> Array:
    """(n,) power density per hertz of the noise of each position: the level in the upper half of its spectrum."""
    longest = max(segments, key=lambda part: part.stop - part.start)
    levels = [_spectrum(column, rate) for column in positions[longest].T]
    return np.array([np.median(power[len(power) // 2 :]) for _, power in levels])
