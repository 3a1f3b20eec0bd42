"""Residuals where a joint stands: dry friction at rest takes any value between its limits, and none is an error."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from symdyn.numeric.observation import Observation
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

REST = 3.0  # standard deviations of a speed's own noise: a slower joint has no direction that could be told
TOUCHED = 0.02  # weight of standing samples in the analysis band's filter from which a sample counts as standing
JUMP = 1e-6  # of the largest effort: a smaller difference between the two directions is no dry friction
BARELY = 1e-9  # of the top speed: enough for a direction, nothing else


def admissible_residual(bench: Workbench, p: Array) -> Array:
    """(K, n) measured effort less what the model admits, in the analysis band.

    Of a moving joint that is inverse dynamics. Of a joint that stands, Coulomb's law is a set: any
    force between those of starting either way holds it (Filippov 1988). The residual is then the
    distance from that set, zero within it. Without dry friction in the model the set is one number.
    """
    residual = bench.residual(p)
    o = bench.observation
    resting = np.abs(o.qd) < REST * speed_noise(o)
    for j in np.flatnonzero(resting.any(axis=0)):
        slow = BARELY * max(float(np.max(np.abs(o.qd[:, j]))), BARELY)
        ends = []
        for direction in (-slow, slow):
            speed = o.qd.copy()
            speed[resting[:, j], j] = direction
            ends.append(bench.bring(bench.raw_residual(p, speed))[:, j])
        low, high = np.minimum(*ends), np.maximum(*ends)
        touched = bench.bring(resting[:, [j]].astype(float))[:, 0] > TOUCHED
        distance = np.where(low > 0.0, low, np.where(high < 0.0, high, 0.0))
        dry = touched & (high - low > JUMP * float(np.max(np.abs(bench.reference[:, j]), initial=0.0)))
        residual[dry, j] = distance[dry]
    return residual


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
