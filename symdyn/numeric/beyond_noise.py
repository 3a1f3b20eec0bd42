"""How much of what is left is more than sensors and sampling account for."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, signal, stats

from symdyn.numeric.noise_floor import loudest_density, power_density
from symdyn.numeric.observation import passed
from symdyn.numeric.position_spectrum import spectrum
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

PASSES = 1.5  # times the band's edge: beyond, its own filter leaves a thousandth
TIMES = 4.0  # the accounted power: twice the amplitude
SEGMENTS = 8  # of Welch's spectrum
FINE = 257  # frequencies of a sum over the band
NEAR = 41  # bins whose median is the level around a line


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
    rate = bench.samples_per_period * bench.edge
    length = min(len(residual), max(32, len(residual) // SEGMENTS))
    frequency, left = signal.welch(residual, rate, nperseg=length, axis=0, detrend="constant")
    seen = (frequency > 0.0) & (frequency <= PASSES * bench.edge)
    lines = [_line(column, rate, PASSES * bench.edge) for column in residual.T]
    accounted = _of_sensors(bench, p, frequency[seen]) * np.mean(bench.counted != 0.0, axis=0)
    kept = passed(frequency[seen, None], bench.observation.rate, np.array(bench.edge)) ** 2
    noise = np.maximum(np.sum(kept * (accounted + hidden**2 / bench.edge), axis=0), 1e-300)
    freedom = 2.0 * len(residual) / length
    found = []
    for power, known_noise, line in zip(left[seen].T, noise.tolist(), lines, strict=True):
        total = max(float(power.sum()), 1e-300)
        # A sum of unequal chi-squared numbers is near one with the freedom of Satterthwaite (1946).
        of_sum = freedom * total**2 / float(np.sum(power**2) + 1e-300)
        p_value = float(stats.chi2.sf(of_sum * total / (TIMES * known_noise), of_sum))
        share = max(1.0 - known_noise / total, 0.0)
        found.append(Beyond(share, p_value, math.sqrt(total / known_noise), line))
    return found


def left_by_positions(bench: Workbench, p: Array, error: Callable[[Array], Array] | None = None) -> Array:
    """(n,) root mean square of what the noise of positions alone leaves of a residual in the band.

    Or of that part of their second derivative which ``error`` tells at a frequency in radians per sample.
    """
    o = bench.observation
    frequency = np.linspace(0.0, min(PASSES * bench.edge, 0.5 * o.rate), FINE)[1:]
    passes = passed(frequency[:, None], o.rate, o.motions)
    kept = passed(frequency[:, None], o.rate, np.array(bench.edge)) ** 2
    part = passes if error is None else passes * error(2.0 * np.pi * frequency[:, None] / o.rate)
    density = _forces(bench, p, frequency, part**2 * o.noise)
    return np.asarray(np.sqrt(np.sum(kept * density, axis=0) * frequency[0]))


def _line(residual: Array, rate: float, edge: float) -> float:
    """p-value of the frequency that stands out most from those around it, all of them counted.

    The bins of a periodogram of noise are exponentially distributed, with its level there as their mean.
    """
    frequency, power = signal.periodogram(residual, rate, window="hann")
    power = power[(frequency > 0.0) & (frequency <= edge)]
    mean = np.maximum(ndimage.median_filter(power, NEAR, mode="reflect") / math.log(2.0), 1e-300)
    return float(min(1.0, len(power) * math.exp(-float(np.max(power / mean)))))


def _of_sensors(bench: Workbench, p: Array, frequency: Array) -> Array:
    """(m, n) power density of the noise of efforts, and of what is not known of accelerations, times the inertias.

    That is the noise of positions, as far as their filter lets it pass, and what that filter takes of the motion: what
    is seen of it beyond noise, and what noise may hide, which is no more than the efforts show there.
    """
    o = bench.observation
    passes = passed(frequency[:, None], o.rate, o.motions)
    longest = max(o.segments, key=lambda part: part.stop - part.start)
    shown = np.stack([np.interp(frequency, *spectrum(q, o.rate)) for q in o.measured[longest].T], axis=1)
    noise = o.noise
    known = passes**2 * noise + (1.0 - passes) ** 2 * np.maximum(shown - noise, 0.0)
    hidden = _forces(bench, p, frequency, (1.0 - passes) ** 2 * np.minimum(shown, noise))
    at_least = np.minimum(hidden, _efforts(bench, frequency)) if np.any(o.tau) else hidden
    return np.asarray(loudest_density(bench, p) ** 2 + _forces(bench, p, frequency, known) + at_least)


def _efforts(bench: Workbench, frequency: Array) -> Array:
    """(m, n) power density of the efforts, as residuals show them."""
    o = bench.observation
    at, power, _ = power_density(o.tau * o.shown, o)
    return np.stack([np.interp(frequency, at, column) for column in power.T], axis=1)


def _forces(bench: Workbench, p: Array, frequency: Array, positions: Array) -> Array:
    """(m, n) power density of the efforts that accelerations need, from that of positions."""
    o = bench.observation
    inertia = bench.kernel.rows("mass_matrix_p", o.q, p)
    accelerations = (2.0 * np.pi * frequency[:, None]) ** 4 * positions
    return np.asarray(accelerations @ np.mean(inertia**2, axis=0).T * o.shown**2)
