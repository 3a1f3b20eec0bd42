"""Where a joint stands still: dry friction takes any value there, so that its equation says nothing about the model."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from symdyn.numeric.observation import Observation

Array = NDArray[np.float64]

REST = 3.0  # standard deviations of a speed's own noise: a slower joint has no direction that could be told
TOUCHED = 0.02  # weight of standing samples in the analysis band's filter from which a sample counts as standing
MOSTLY = 0.5  # of the samples: a joint that stands longer is not judged by the rest


def resting(observation: Observation) -> NDArray[np.bool_]:
    """(N, n) where no direction of motion can be told."""
    return np.asarray(np.abs(observation.qd) < REST * speed_noise(observation))


def touched(observation: Observation, bring: Callable[[Array], Array]) -> NDArray[np.bool_]:
    """(K, n) samples in the analysis band that hold some of those."""
    return np.asarray(np.abs(bring(resting(observation).astype(float))) > TOUCHED)


def speed_noise(observation: Observation) -> Array:
    """(n,) standard deviation of the noise in ``observation.qd``: the position's floor, differentiated."""
    o = observation
    longest = max(o.segments, key=lambda part: part.stop - part.start)
    bend = np.diff(o.measured[longest], 2, axis=0)
    length = max(64, min(len(bend), 4096) // 2)
    frequency, power = signal.welch(bend, o.rate, nperseg=min(length, len(bend)), axis=0)
    upper = frequency > 0.5 * frequency[-1]
    density = power[upper] / (2.0 * np.sin(np.pi * frequency[upper, None] / o.rate)) ** 4
    floor = np.median(density, axis=0)
    return np.asarray(np.sqrt(floor * (2.0 * np.pi) ** 2 * o.cutoff**3 / 3.0))
