"""What one sample's measurements tell a filter: innovations, gains, and the state and sensitivities after them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

SURPRISE = 3.0  # standard deviations, beyond which an innovation costs in proportion to itself (Huber 1964)


@compiled
def measured(
    y: Array, signals: Counts, r: Array, out: Array, c_all: Array, outputs_by_p: Array, which: Counts, q: int,
    steady: bool, here: Array, w: Array, cov: Array, gains: Array, spread: Array, dz: Array, row: Array, shown: Array,
    loss: float, e: Array, s: Array, de: Array,
) -> tuple[float, bool]:  # fmt: skip
    """-log L with this sample, and whether gains are as before; arrays as for ``kalman.run``, of one filter and sample.

    The state ``here`` (n,), forces ``w`` (l,), ``cov`` and ``dz`` change in place, one channel after the other; where
    ``steady``, neither gains nor ``cov`` do. ``out``, ``c_all`` and ``outputs_by_p`` are outputs at the state before,
    and their derivatives; of ``q`` parameters sensitivities follow. ``row`` (nz,) and ``shown`` (n,) are for use here.
    """
    n, nz = len(here), len(row)
    for i in range(n):
        shown[i] = here[i]
    for c in range(len(y)):
        if np.isnan(y[c]):
            e[c], s[c] = 0.0, 1.0
            for j in range(q):
                de[c, j] = 0.0
            steady = False
            continue
        index, gain = signals[c], gains[c]
        if index < n:
            for i in range(nz):
                row[i] = 1.0 if i == index else 0.0
            value = here[index]
        else:
            value = out[index - n]
            for i in range(n):
                row[i] = c_all[index - n, i]
                value += row[i] * (here[i] - shown[i])
            for i in range(n, nz):
                row[i] = 0.0
        if not steady:
            for i in range(nz):
                gain[i] = 0.0
            for j in range(nz):
                if row[j] != 0.0:  # most channels show one state
                    for i in range(nz):
                        gain[i] += cov[j, i] * row[j]
            variance = r[c]
            for i in range(nz):
                variance += row[i] * gain[i]
            # rounding may make a covariance of nearly nothing negative
            spread[c] = max(variance, r[c])
        variance = spread[c]
        innovation = y[c] - value
        doubt = max(1.0, abs(innovation) / (SURPRISE * np.sqrt(variance)))
        e[c], s[c] = innovation, variance * doubt
        loss += 0.5 * (innovation * innovation / s[c] + np.log(s[c]))
        for j in range(q):
            slope = outputs_by_p[index - n, which[j]] if index >= n else 0.0
            for i in range(n):
                slope += row[i] * dz[i, j]
            de[c, j] = -slope
        for i in range(nz):
            part = gain[i] / variance
            if i < n:
                here[i] += part * innovation
            else:
                w[i - n] += part * innovation
            for j in range(q):
                dz[i, j] += part * de[c, j]
            if not steady:
                for j in range(nz):
                    cov[i, j] -= part * gain[j]
    return loss, steady
