"""What the plots show, as arrays: windows, thinned points, binned means, spectra."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Array = NDArray[np.float64]


def runs(time: Array) -> list[slice]:
    """The stretches of ``time`` (K,) without a gap."""
    step = np.diff(time)
    breaks = np.flatnonzero(step > 1.5 * np.median(step)) + 1
    edges = [0, *breaks.tolist(), len(time)]
    return [slice(start, stop) for start, stop in pairwise(edges)]


def longest_run(time: Array) -> slice:
    return max(runs(time), key=lambda run: run.stop - run.start)


def worst_window(time: Array, relative: Array, samples: int) -> slice:
    """Where ``relative`` (K, n) is largest over ``samples`` in a row, within one run."""
    longest = longest_run(time)
    samples = min(samples, longest.stop - longest.start)
    best, where = -1.0, slice(0, samples)
    for run in runs(time):
        if run.stop - run.start < samples:
            continue
        total = np.concatenate([[0.0], np.cumsum(np.sum(relative[run] ** 2, axis=1))])
        power = total[samples:] - total[:-samples]
        start = int(np.argmax(power))
        if power[start] > best:
            best, where = float(power[start]), slice(run.start + start, run.start + start + samples)
    return where


def thinned(count: int, limit: int) -> NDArray[np.intp]:
    """At most ``limit`` of ``count`` indices, drawn evenly but not in step with any periodic motion."""
    if count <= limit:
        return np.arange(count)
    return np.sort(np.random.default_rng(0).choice(count, limit, replace=False))


def binned_mean(x: Array, y: Array, bins: int, fewest: int = 4) -> tuple[Array, Array]:
    """Means of ``x`` and ``y`` (K,) over equally wide bins of ``x``; those of fewer samples are left out."""
    edges = np.linspace(x.min(), x.max(), bins + 1)[1:-1]
    index = np.digitize(x, edges)
    count = np.bincount(index, minlength=bins)
    kept = count >= min(fewest, len(x))
    means = (np.bincount(index, values, minlength=bins)[kept] / count[kept] for values in (x, y))
    return next(means), next(means)


def amplitude_density(time: Array, values: Array) -> tuple[Array, Array]:
    """Welch's estimate over the longest run: frequencies in Hz, amplitude per root hertz (F, n)."""
    run = longest_run(time)
    length = run.stop - run.start
    rate = 1.0 / float(np.median(np.diff(time[run])))
    frequency, power = signal.welch(values[run], rate, nperseg=min(256, length), axis=0, detrend="constant")
    return frequency[1:], np.sqrt(power[1:])
