"""How far and how fast a place moves, as a fit has it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.judged import Explanation
from symdyn.numeric.filtering.places import Latent

Array = NDArray[np.float64]

OFTEN = 0.95  # of the samples are slower than a usual top speed


@dataclass(frozen=True, slots=True)
class Travel:
    """Of displacements the width between the two ends; of speeds the fastest, and that which is seldom exceeded.

    ``stroke``: the mean time (s) between two reversals.
    """

    width: float
    fastest: float
    usual: float
    stroke: float


def travel(of: Explanation, latent: Latent) -> Travel:
    """Of the training recordings, by the states that the filter followed."""
    n, bench = len(latent.motion), of.fit.bench
    states = bench.filtered(of.fit.p).states
    displacement, velocity = states[:, :n] @ latent.motion, states[:, n : 2 * n] @ latent.motion
    reversals = np.count_nonzero(np.diff(np.sign(velocity)))
    return Travel(
        width=float(np.ptp(displacement)),
        fastest=float(np.max(np.abs(velocity))),
        usual=max(float(np.quantile(np.abs(velocity), OFTEN)), 1e-12),
        stroke=float(np.nansum(bench.signals.steps)) / (1.0 + reversals),
    )
