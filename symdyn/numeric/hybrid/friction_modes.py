"""Which bodies stick and which slip when speeds are zero: a linear complementarity problem with box bounds."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled
from symdyn.numeric.hybrid.vectors import solve

Array = NDArray[np.float64]

MOST_TURNS = 60  # principal pivots tried before the sweep takes over


@compiled
def friction_at_rest(free: Array, effect: Array) -> Any:
    """Share sigma (n,) of each friction's limit, in [-1, 1], at n guards whose speed is zero.

    ``free`` (n,) is the rate of each speed without their friction, ``effect`` (n, n) how much of it one
    unit of each sigma takes away: a = free - effect sigma, with ``effect`` similar to a positive
    definite matrix. A body sticks (|sigma| < 1, a = 0), or sets off with sigma = sign(a).

    Filippov's convention at a surface of discontinuity. Principal pivoting, which ends for such matrices;
    should rounding make it cycle, projected Gauss-Seidel sweeps finish.
    """
    n = len(free)
    sigma = np.zeros(n)
    bound = np.zeros(n)  # 0: sticks; +-1: slips that way
    for _ in range(MOST_TURNS):
        count = 0
        for i in range(n):
            if bound[i] == 0.0:
                count += 1
        stuck = np.empty(count, np.int64)
        k = 0
        for i in range(n):
            if bound[i] == 0.0:
                stuck[k] = i
                k += 1
        right = np.empty((count, 1))
        matrix = np.empty((count, count))
        for r in range(count):
            i = stuck[r]
            right[r, 0] = free[i]
            for j in range(n):
                right[r, 0] -= effect[i, j] * bound[j]
            for c in range(count):
                matrix[r, c] = effect[i, stuck[c]]
        for i in range(n):
            sigma[i] = bound[i]
        solve(matrix, right, count)
        for r in range(count):
            sigma[stuck[r]] = right[r, 0]
        # Change the first that is wrong: the least-index rule cannot cycle for P-matrices (Murty 1974).
        wrong = -1
        for i in range(n):
            if bound[i] == 0.0:
                if abs(sigma[i]) > 1.0:
                    wrong = i
                    break
            else:
                rate = free[i]
                for j in range(n):
                    rate -= effect[i, j] * sigma[j]
                if rate * bound[i] < 0.0:
                    wrong = i
                    break
        if wrong < 0:
            return sigma, bound
        bound[wrong] = 0.0 if bound[wrong] != 0.0 else np.sign(sigma[wrong])
    return _sweep(free, effect)


@compiled
def _sweep(free: Array, effect: Array) -> Any:
    n = len(free)
    sigma = np.zeros(n)
    for _ in range(10_000):
        change = 0.0
        for i in range(n):
            rate = free[i]
            for j in range(n):
                rate -= effect[i, j] * sigma[j]
            new = min(1.0, max(-1.0, sigma[i] + rate / effect[i, i]))
            change = max(change, abs(new - sigma[i]))
            sigma[i] = new
        if change < 1e-14:
            break
    bound = np.zeros(n)
    for i in range(n):
        if abs(sigma[i]) >= 1.0:
            bound[i] = sigma[i]
    return sigma, bound
