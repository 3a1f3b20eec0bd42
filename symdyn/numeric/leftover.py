"""Whether what is left has structure: it follows the motion, or is slow where noise would be even."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy import signal, stats

from symdyn.numeric.findings import Remaining
from symdyn.numeric.regression import encompassing

Array = NDArray[np.float64]

BINS = 16  # equally filled bins of one variable: any shape, no assumption on it
BINS_OF_PAIR = 8  # of each of two variables
LEVEL = 0.01
SHARE = 0.1  # structure worth naming: a tenth of what is left
SLOW_SHARE = 0.5  # without any variable to name, half of it

Data = tuple[Array, Array]  # residual (K, n) and variables (K, v)


def leftover(
    training: Data,
    heldout: Data,
    variables: Sequence[str],
    error: float,
    per_band: float,
    floor: Array | None = None,
    known: float = 1.0,
) -> Remaining:
    """Learn the training residual as a free-form function of the motion; see what that predicts held out.

    ``variables`` names the v columns. One variable at a time, and pairs of them where no single one
    tells: a curve or surface that predicts the residual of another recording is structure. Its share
    of the residual's power, and the variables, are reported. What no variable tells may still be no
    noise: ``per_band`` samples per period of the band's edge, its spectrum is asked. ``floor`` (n,) is the root mean
    square that the sensors' noise alone has in the band, where that is known from outside the band. ``known`` is the
    part of the band in which the motion of every joint is seen: beyond, residuals lack what it does, and its noise.
    """
    single = [(j,) for j in range(len(variables))]
    found = _best(training, heldout, variables, single, BINS, error)
    if found.structured:
        return found
    pairs = list(combinations(range(len(variables)), 2))
    together = _best(training, heldout, variables, pairs, BINS_OF_PAIR, error)
    if together.structured:
        return together
    share, p_value = slow_share(heldout[0], per_band, floor, known)
    return Remaining(error, True, share, None, p_value) if share > SLOW_SHARE and p_value < LEVEL else found


def slow_share(residual: Array, per_band: float, floor: Array | None = None, known: float = 1.0) -> tuple[float, float]:
    """Share of the power that the lower half of the band has above the level of its upper half, and its p-value.

    Sensor noise is even over the band, or grows with frequency where positions were differentiated;
    a mismatch lives in the lower half of a band that was chosen to hold it twice over. ``residual``
    (K, n) has ``per_band`` samples per period of the band's edge. Level and scatter are those of
    Welch's spectrum: each bin is chi-squared with two degrees of freedom per independent segment.
    What noise of the level ``floor`` (n,) would leave is no structure, however it is spread. Where motion is
    seen in part of the band, ``known``, that part is asked.
    """
    best = (0.0, 1.0)
    levels = np.zeros(residual.shape[1]) if floor is None else floor
    edge = min(known, 1.0)
    for column, level in zip(residual.T, levels, strict=True):
        length = min(len(column), max(32, len(column) // 8))
        frequency, power = signal.welch(column, per_band, nperseg=length, detrend="constant")
        half = 0.5 * edge + 2.0 * frequency[1]  # a line at the middle spreads over two bins of the window
        low = power[(frequency > 0) & (frequency <= half)]
        high = power[(frequency > half) & (frequency <= 0.9 * edge)]
        if len(low) == 0 or len(high) == 0 or not high.any():
            continue
        freedom = 2.0 * len(column) / length
        p_value = float(stats.f.sf(low.mean() / high.mean(), freedom * len(low), freedom * len(high)))
        excess = float(low.sum() - high.mean() * len(low))
        share = min(excess / float(power[frequency <= 1.0].sum()), 1.0 - level**2 / float(np.mean(column**2)))
        best = max(best, (share, min(1.0, p_value * residual.shape[1])))
    return best


def _best(
    training: Data, heldout: Data, variables: Sequence[str], subsets: Sequence[Sequence[int]], bins: int, error: float
) -> Remaining:
    (r_train, x_train), (r_held, x_held) = training, heldout
    size = np.sqrt(np.mean(r_train**2, axis=0)) + 1e-300
    before = r_held / size
    power = max(float(np.mean(np.sum(before**2, axis=1))), 1e-300)
    best = Remaining(error, False, 0.0, None, 1.0)
    for subset in subsets:
        cell_train, cell_held = np.zeros(len(x_train), dtype=int), np.zeros(len(x_held), dtype=int)
        for j in subset:
            edges = np.quantile(x_train[:, j], np.linspace(0, 1, bins + 1)[1:-1])
            cell_train = cell_train * bins + np.digitize(x_train[:, j], edges)
            cell_held = cell_held * bins + np.digitize(x_held[:, j], edges)
        after = (r_held - _means(r_train, cell_train, bins ** len(subset))[cell_held]) / size
        gain, p_value = encompassing(before, after)
        share, p_value = gain / power, min(1.0, p_value * len(subsets))
        if share > best.share and p_value < LEVEL:
            best = Remaining(error, share > SHARE, share, " and ".join(variables[j] for j in subset), p_value)
    return best


def _means(residual: Array, cell: NDArray[np.int_], cells: int) -> Array:
    """Mean residual of each cell, shrunk towards zero where few samples are: (cells, n)."""
    count = np.bincount(cell, minlength=cells)
    sums = [np.bincount(cell, weights=column, minlength=cells) for column in residual.T]
    return np.stack(sums, axis=1) / (count[:, None] + 1.0)
