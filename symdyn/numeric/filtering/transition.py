"""One step of a machine between two samples: the exponential of its Jacobian, and the integral of that."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled

Array = NDArray[np.float64]

TERMS = 7  # of the series at the shortest step
SWEEPS = 2  # of balancing
TINY = 1e-3
SHORT = 0.1  # largest row sum of A h at the shortest step: its series is then exact to 1e-12


@compiled
def product(a: Array, b: Array, out: Array) -> None:
    """out = a b, row by row so that inner loops run along memory."""
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            out[i, j] = 0.0
        for k in range(a.shape[1]):
            factor = a[i, k]
            if factor != 0.0:
                for j in range(b.shape[1]):
                    out[i, j] += factor * b[k, j]


@compiled
def balanced_norm(a: Array) -> float:
    """Largest row sum of |D A D^-1|, D diagonal and chosen to make it small (Osborne 1960): free of units.

    The series of exp(A) is as good as that of the balanced matrix, entry by entry.
    """
    n = len(a)
    d = np.ones(n)
    for _ in range(SWEEPS):
        for i in range(n):
            row, column = 0.0, 0.0
            for j in range(n):
                if j != i:
                    row += abs(a[i, j]) * d[j]
                    column += abs(a[j, i]) / d[j]
            if row > 0.0 and column > 0.0:
                d[i] = np.sqrt(row / column)
            elif column > 0.0:  # what nothing changes may be as large as it likes
                d[i] *= TINY
    largest = 0.0
    for i in range(n):
        row = 0.0
        for j in range(n):
            row += abs(a[i, j]) * d[j] / d[i]
        largest = max(largest, row)
    return largest


@compiled
def transition(a: Array, step: float, change: Array, integral: Array, ramp: Array) -> None:
    """change = exp(A h) - 1, integral of exp(A t) over 0..h, ramp = the integral of that, all (n, n).

    A constant source c adds integral c to the state, one that grows as c t / h adds ramp c / h. By series and doubling.
    """
    n = len(a)
    largest = balanced_norm(a)
    doublings = 0
    while largest * step * 0.5**doublings > SHORT and doublings < 60:
        doublings += 1
    h = step * 0.5**doublings
    term, work = np.eye(n) * h, np.empty((n, n))
    integral[:] = term
    ramp[:] = term * (h / 2.0)
    for k in range(2, TERMS + 1):
        product(term, a, work)
        for i in range(n):
            for j in range(n):
                term[i, j] = work[i, j] * (h / k)
                integral[i, j] += term[i, j]
                ramp[i, j] += term[i, j] * (h / (k + 1))
    product(a, integral, change)
    for _ in range(doublings):
        product(integral, integral, work)
        for i in range(n):
            for j in range(n):
                ramp[i, j] = 2.0 * ramp[i, j] + work[i, j]
        product(change, integral, work)
        for i in range(n):
            for j in range(n):
                integral[i, j] = 2.0 * integral[i, j] + work[i, j]
        product(change, change, work)
        for i in range(n):
            for j in range(n):
                change[i, j] = 2.0 * change[i, j] + work[i, j]
