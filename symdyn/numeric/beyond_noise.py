"""How much of what is left is more than sensors and sampling account for, where the motion is known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, signal, stats

from symdyn.numeric.noise_floor import loudest_density
from symdyn.numeric.position_noise import position_density
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

KNOWN = 0.7  # of the frequency where a position sinks into its noise: beyond, its filter takes part of the motion away
TIMES = 4.0  # the accounted power: twice the amplitude
SEGMENTS = 8  # of Welch's spectrum
NEAR = 9  # bins whose median is the level around a line


@dataclass(frozen=True, slots=True)
class Beyond:
    """What is left at one joint, beside the noise that is accounted for."""

    share: float = 0.0  # of its power that is more
    p_value: float = 1.0  # of "no more than ``TIMES`` that noise"
    times: float = 0.0  # that noise, in amplitude
    line: float = 1.0  # p-value of "no frequency stands out": the noise of a sensor has none that does


def beyond_noise(bench: Workbench, p: Array, residual: Array, hidden: Array) -> list[Beyond]:
    """Of a residual (K, n) in the band of ``bench``: spectra of what is left beside those of what leaves it.

    ``hidden`` (n,) is the root mean square that samples and the steps of known encoders leave. Welch's spectra are
    chi-squared, with two degrees of freedom per independent segment.
    """
    o = bench.observation
    rate = bench.samples_per_period * bench.edge
    known = KNOWN * min(bench.edge, float(np.min(o.motions)))
    length = min(len(residual), max(32, len(residual) // SEGMENTS))
    frequency, left = signal.welch(residual, rate, nperseg=length, axis=0, detrend="constant")
    seen = (frequency > 0.0) & (frequency <= known)
    if not seen.any():
        return [Beyond()] * residual.shape[1]
    accounted = _of_sensors(bench, p, frequency[seen]) * np.mean(bench.counted != 0.0, axis=0)
    noise = np.maximum(np.sum(accounted + hidden**2 / bench.edge, axis=0), 1e-300)
    freedom = 2.0 * len(residual) / length
    found, whole_band = [], left[frequency <= bench.edge]
    for power, whole, known_noise in zip(left[seen].T, whole_band.T, noise.tolist(), strict=True):
        total = float(power.sum())
        # A sum of unequal chi-squared numbers is near one with the freedom of Satterthwaite (1946).
        of_sum = freedom * total**2 / max(float(np.sum(power**2)), 1e-300)
        p_value = float(stats.chi2.sf(of_sum * total / (TIMES * known_noise), of_sum))
        share = max(total - known_noise, 0.0) / max(float(whole.sum()), 1e-300)
        found.append(Beyond(share, p_value, math.sqrt(total / known_noise), _line(power, freedom)))
    return found


def _line(power: Array, freedom: float) -> float:
    """p-value of the bin that stands out most from those around it, all of them counted."""
    around = np.maximum(ndimage.median_filter(power, NEAR, mode="nearest"), 1e-300)
    return float(min(1.0, len(power) * stats.chi2.sf(freedom * np.max(power / around), freedom)))


def _of_sensors(bench: Workbench, p: Array, frequency: Array) -> Array:
    """(m, n) power density of the noise of efforts, and of all positions, twice differentiated, times the inertias."""
    o = bench.observation
    inertia = bench.kernel.mass_matrix_p_batch(np.ascontiguousarray(o.q), p)
    positions = np.mean(inertia**2, axis=0) @ position_density(o) * o.shown**2
    accelerations: Array = (2.0 * np.pi * frequency[:, None]) ** 4 * positions
    return np.asarray(loudest_density(bench, p) ** 2 + accelerations)
