"""Whether what is left still follows the motion: structure that no known effect explains."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.findings import Remaining
from symdyn.numeric.regression import encompassing

Array = NDArray[np.float64]

BINS = 16  # equally filled bins of one variable: any shape, no assumption on it
BINS_OF_PAIR = 8  # of each of two variables
LEVEL = 0.01
SHARE = 0.1  # structure worth naming: a tenth of what is left

Data = tuple[Array, Array]  # residual (K, n) and variables (K, v)


def leftover(training: Data, heldout: Data, variables: Sequence[str], error: float) -> Remaining:
    """Learn the training residual as a free-form function of the motion; see what that predicts held out.

    ``variables`` names the v columns. One variable at a time, and pairs of them where no single one
    tells: a curve or surface that predicts the residual of another recording is structure. Its share
    of the residual's power, and the variables, are reported.
    """
    single = [(j,) for j in range(len(variables))]
    found = _best(training, heldout, variables, single, BINS, error)
    if found.structured:
        return found
    pairs = list(combinations(range(len(variables)), 2))
    together = _best(training, heldout, variables, pairs, BINS_OF_PAIR, error)
    return together if together.structured else found


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
