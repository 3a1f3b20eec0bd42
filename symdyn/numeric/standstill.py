"""Residuals where a joint stands: dry friction at rest takes any value between its limits, and none is an error."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.rest import resting, touched
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

JUMP = 1e-6  # of the largest effort: a smaller difference between the two directions is no dry friction
BARELY = 1e-9  # of the top speed: enough for a direction, nothing else


def admissible_residual(bench: Workbench, p: Array) -> Array:
    """(K, n) measured effort less what the model admits, in the analysis band.

    Of a moving joint that is inverse dynamics. Of a joint that stands, Coulomb's law is a set: any
    force between those of starting either way holds it (Filippov 1988). The residual is then the
    distance from that set, zero within it. Without dry friction in the model the set is one number. Where a joint
    turns faster than its motion is known nothing is counted.
    """
    residual = bench.bring(bench.raw_residual(p))
    o = bench.observation
    still, near = resting(o), touched(o, bench.bring)
    for j in np.flatnonzero(still.any(axis=0)):
        slow = BARELY * max(float(np.max(np.abs(o.qd[:, j]))), BARELY)
        ends = []
        for direction in (-slow, slow):
            speed = o.qd.copy()
            speed[still[:, j], j] = direction
            ends.append(bench.bring(bench.raw_residual(p, speed))[:, j])
        low, high = np.minimum(*ends), np.maximum(*ends)
        distance = np.where(low > 0.0, low, np.where(high < 0.0, high, 0.0))
        dry = near[:, j] & (high - low > JUMP * float(np.max(np.abs(bench.reference[:, j]), initial=0.0)))
        residual[dry, j] = distance[dry]
    return np.where(bench.turning & (bench.counted == 0.0), 0.0, residual * o.shown)
