"""One step of a machine between two samples: the exponential of its Jacobian, and the integral of that."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled
from symdyn.numeric.hybrid.vectors import LANES, times

Array = NDArray[np.float64]

TERMS = 12  # of the series at the shortest step
SWEEPS = 2  # of balancing
TINY = 1e-3
SHORT = 0.8  # largest row sum of A h at the shortest step: its series is then exact to 1e-11


@compiled
def room(count: int) -> int:
    """The next multiple of what ``product`` multiplies at once."""
    return -(-count // LANES) * LANES


@compiled
def product(a: Array, b: Array, rows: int, inner: int, out: Array) -> None:
    """out[:rows] = a[:rows, :inner] b[:inner]; all of them with room, and where ``inner`` is odd b[inner] is zero."""
    across = b.shape[1]
    for i in range(rows):
        times(b, 0, across, a, i * a.shape[1], inner + inner % 2, out, i * across)


@compiled
def balanced_norm(a: Array, n: int) -> float:
    """Largest row sum of |D A D^-1|, D diagonal and chosen to make it small (Osborne 1960): free of units.

    The series of exp(A) is as good as that of the balanced matrix, entry by entry.
    """
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
def transition(
    a: Array, n: int, step: float, ramped: bool, change: Array, integral: Array, ramp: Array, term: Array, work: Array
) -> None:
    """change = exp(A h) - 1, integral of exp(A t) over 0..h, ramp = the integral of that; of all, (n, n) with room.

    A constant source c adds integral c to the state, one that grows as c t / h adds ramp c / h. By series and doubling.
    ``ramp`` only where ``ramped``; ``term`` and ``work`` are for use here.
    """
    largest = balanced_norm(a, n)
    doublings = 0
    while largest * step * 0.5**doublings > SHORT and doublings < 60:
        doublings += 1
    h = step * 0.5**doublings
    count = n * a.shape[1]
    flat_change, flat_integral, flat_ramp = change.ravel(), integral.ravel(), ramp.ravel()  # views
    flat_term, flat_work = term.ravel(), work.ravel()
    term[:], integral[:], ramp[:] = 0.0, 0.0, 0.0
    for i in range(n):
        term[i, i] = integral[i, i] = h
        ramp[i, i] = 0.5 * h * h
    for k in range(2, TERMS + 1):
        product(a, term, n, n, work)
        for i in range(count):
            flat_term[i] = flat_work[i] * (h / k)
            flat_integral[i] += flat_term[i]
        if ramped:
            for i in range(count):
                flat_ramp[i] += flat_term[i] * (h / (k + 1))
    product(a, integral, n, n, change)
    for _ in range(doublings):
        if ramped:
            product(integral, integral, n, n, work)
            for i in range(count):
                flat_ramp[i] = 2.0 * flat_ramp[i] + flat_work[i]
        product(change, integral, n, n, work)
        for i in range(count):
            flat_integral[i] = 2.0 * flat_integral[i] + flat_work[i]
        product(change, change, n, n, work)
        for i in range(count):
            flat_change[i] = 2.0 * flat_change[i] + flat_work[i]
