"""Free runs over short windows: what a model predicts by itself from a state that was estimated at their start."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.signals import Signals

Array = NDArray[np.float64]

WINDOW = 0.25  # s
FEWEST = 8  # samples of a window
NEGLIGIBLE = 1e-4  # of how far a channel moves in a window: what steps of a filter, or of a simulation, may leave
SHARE = 0.1  # of an error's power: what is beyond noise by less is not worth a word


def free_runs(bench: FilterBench, p: Array) -> Array:
    """(N, m) prediction of every channel, started anew from the filter's state every ``WINDOW`` seconds.

    Latent forces are left out: this is the model alone. Where a gap cuts a window it ends. The first one begins a
    moment late, a quarter of the stretch at most: until then speeds and twists that nobody measures are a guess.
    """
    s = bench.signals
    n = len(bench.kernel.states)
    states = bench.filtered(p).states[:, :n]
    length, moment = _length(s), max(1, round(bench.settling / float(np.nanmedian(s.steps))))
    predicted = np.full_like(s.y, np.nan)
    ends = [0, *(int(i) + 1 for i in np.flatnonzero(np.isnan(s.steps)))]
    for first, last in pairwise(ends):
        for start in range(first + min(moment, (last - first) // 4), last, length):
            stop = min(start + length, last)
            if stop - start >= FEWEST:
                predicted[start:stop] = bench.simulated(p, states[start], start, stop)
    return predicted


def relative_errors(bench: FilterBench, predicted: Array) -> Array:
    """(m + t,) size of the prediction's error, over how far each channel moves from the start of its window."""
    return np.asarray(np.sqrt(np.nanmean(off(bench.signals, predicted) ** 2, axis=0)))


def off(signals: Signals, predicted: Array) -> Array:
    """(N, m + t) errors of a prediction (N, m), of channels and of twists between them, over how far each moves."""
    return np.asarray(signals.with_differences(signals.y - predicted) / sizes(signals))


def sizes(signals: Signals) -> Array:
    """(m + t,) how far each channel moves within a window, and each twist, as a standard deviation."""
    length = _length(signals)
    shown = signals.with_differences(signals.y)
    moved = shown[length:] - shown[:-length]
    size = np.sqrt(np.nanmean(moved**2, axis=0) / 2.0)
    return np.where(size > 0, size, 1.0)


def noise_alone(signals: Signals, noise: Array) -> Array:
    """(m + t,) errors that sensors' noise of variances ``noise`` (m,) alone would leave, as far as that noise is white.

    Two encoders of what a model takes for one part leave it no choice but to call all that twists between them noise.
    """
    power = np.minimum(noise, white_noise(signals))
    if signals.twists is not None:
        power = np.append(power, signals.twists**2 @ power)
    return np.asarray(np.sqrt(power) / sizes(signals))


def white_noise(signals: Signals) -> Array:
    """(m,) the largest variance that white noise of each channel can have, by third differences: no motion is in less.

    Never below that of the channel's own steps.
    """
    return np.maximum(white(signals.y, signals.steps), signals.floor)


def white(values: Array, steps: Array) -> Array:
    """(m,) the same of values (N, m), of which each comes ``steps`` (N,) before the next; inf where nothing tells."""
    whole = np.lib.stride_tricks.sliding_window_view(np.isfinite(steps[:-1]), 3).all(axis=1)
    jerks = np.diff(values, n=3, axis=0)[whole]
    power = np.nanmean(jerks**2, axis=0) / 20.0 if len(jerks) else np.full(values.shape[1], np.inf)
    return np.where(np.isfinite(power), power, np.inf)


def beyond(error: float, noise: float) -> float:
    """Part of an error's power that the noise does not account for."""
    return max(0.0, 1.0 - (noise / max(error, 1e-300)) ** 2)


def _length(signals: Signals) -> int:
    return max(FEWEST, round(WINDOW / float(np.nanmedian(signals.steps))))


def overall(errors: Array) -> float:
    """Channels count alike (root mean square)."""
    return float(np.sqrt(np.mean(errors**2)))
