"""The noise of measured positions: its level, and what it makes of a speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from symdyn.numeric.observation import Observation

Array = NDArray[np.float64]


def position_density(observation: Observation) -> Array:
    """(n,) power density of each position's noise per hertz: the level in the upper half of its spectrum."""
    o = observation
    longest = max(o.segments, key=lambda part: part.stop - part.start)
    bend = np.diff(o.measured[longest], 2, axis=0)  # else the slow, large part of the motion leaks over everything
    length = max(64, min(len(bend), 4096) // 2)
    frequency, power = signal.welch(bend, o.rate, nperseg=min(length, len(bend)), axis=0)
    upper = frequency > 0.5 * frequency[-1]
    density = power[upper] / (2.0 * np.sin(np.pi * frequency[upper, None] / o.rate)) ** 4
    return np.asarray(np.median(density, axis=0))


def speed_noise(observation: Observation) -> Array:
    """(n,) standard deviation of the noise in ``observation.qd``: the position's, differentiated."""
    o = observation
    return np.asarray(np.sqrt(position_density(o) * (2.0 * np.pi) ** 2 * o.motions**3 / 3.0))
