"""exp(A h) - 1 for a step and all its halves, each accurate relative to itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled
from symdyn.numeric.hybrid.vectors import matrix_product

Array = NDArray[np.float64]

TERMS = 6  # of the series at the shortest step


@compiled
def growth_rate(a: Array) -> float:
    """An upper bound of the spectral radius of |A|: a few power steps, with the bound of Collatz and Wielandt."""
    n = len(a)
    v = np.ones(n)
    w = np.empty(n)
    best = np.inf
    for _ in range(40):
        for i in range(n):
            w[i] = 0.0
            for j in range(n):
                w[i] += abs(a[i, j]) * v[j]
        worst = 0.0
        top = 0.0
        for i in range(n):
            w[i] += 1e-3 * best * v[i] if best < np.inf else v[i]  # keeps every entry positive
            top = max(top, w[i])
        for i in range(n):
            worst = max(worst, w[i] / v[i])
        best = min(best, worst)
        for i in range(n):
            v[i] = w[i] / top
    return best


@compiled
def expm1_levels(a: Array, rate: float, step: float, out: Array) -> None:
    """out[k] (n, n) = exp(A step / 2^k) - 1, for k from 0 to len(out) - 1; ``rate`` is the growth rate of A.

    The shortest step is summed as a series, each doubling is F -> 2 F + F F. Kept without the
    identity, a doubling adds an error relative to F alone, so that short steps lose nothing.
    """
    n, levels = len(a), len(out)
    halvings = levels - 1
    while rate * step * 0.5**halvings > 0.02:
        halvings += 1
    h = step * 0.5**halvings
    f = np.zeros((n, n))
    term, next_term = np.eye(n), np.empty((n, n))
    for k in range(1, TERMS + 1):
        matrix_product(term, a, next_term)
        for i in range(n):
            for j in range(n):
                term[i, j] = next_term[i, j] * (h / k)
                f[i, j] += term[i, j]
    for k in range(halvings, -1, -1):
        if k < levels:
            out[k] = f
        if k:
            matrix_product(f, f, term)
            for i in range(n):
                for j in range(n):
                    f[i, j] = 2.0 * f[i, j] + term[i, j]


def legendre(count: int) -> tuple[Array, Array]:
    """Points and weights of Gauss and Legendre on (0, 1)."""
    points, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 + 0.5 * points, 0.5 * weights


@compiled
def bound_of_exponential(a: Array, delta: float) -> Array:
    """(n, n) B with |exp(A t)| <= B entry by entry for 0 <= t <= delta: exp(|A| delta), rounded up."""
    n = len(a)
    size = np.abs(a)
    total = np.eye(n)
    term, next_term = np.eye(n), np.empty((n, n))
    for k in range(1, 30):
        matrix_product(term, size, next_term)
        for i in range(n):
            for j in range(n):
                term[i, j] = next_term[i, j] * (delta / k)
                total[i, j] += term[i, j]
    return total * (1.0 + 1e-9)
