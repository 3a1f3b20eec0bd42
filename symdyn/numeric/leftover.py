"""Whether what is left still follows the motion: structure that no known effect explains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.findings import Remaining
from symdyn.numeric.regression import encompassing

Array = NDArray[np.float64]

BINS = 16  # equally filled bins per variable: any shape, no assumption on it
LEVEL = 0.01
SHARE = 0.1  # structure worth naming: a tenth of what is left


def leftover(
    training: tuple[Array, Array], heldout: tuple[Array, Array], variables: Sequence[str], error: float
) -> Remaining:
    """Learn the training residual as a function of one variable at a time; see what that predicts held out.

    ``training`` and ``heldout`` are (residual (K, n), variables (K, v)); ``variables`` names the v
    columns. A free-form curve that predicts the residual of another recording is structure; its
    share of the residual's power, and the variable, are reported.
    """
    (r_train, x_train), (r_held, x_held) = training, heldout
    size = np.sqrt(np.mean(r_train**2, axis=0)) + 1e-300
    before = r_held / size
    best = Remaining(error, False, 0.0, None, 1.0)
    for j, name in enumerate(variables):
        edges = np.quantile(x_train[:, j], np.linspace(0, 1, BINS + 1)[1:-1])
        bin_train, bin_held = np.digitize(x_train[:, j], edges), np.digitize(x_held[:, j], edges)
        mean = np.zeros((BINS, r_train.shape[1]))
        for b in range(BINS):
            inside = bin_train == b
            if inside.any():
                mean[b] = r_train[inside].mean(axis=0)
        after = (r_held - mean[bin_held]) / size
        gain, p_value = encompassing(before, after)
        share = gain / max(float(np.mean(np.sum(before**2, axis=1))), 1e-300)
        if share > best.share and p_value * len(variables) < LEVEL:
            best = Remaining(error, share > SHARE, share, name, p_value * len(variables))
    return best
