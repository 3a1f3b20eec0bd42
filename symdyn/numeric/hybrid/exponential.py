"""exp(A h) - 1 for a step and all its halves, each accurate relative to itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled

Array = NDArray[np.float64]

TERMS = 6  # of the series at the shortest step


@compiled
def growth_rate(a: Array) -> float:
    """An upper bound of the spectral radius of |A|: a few power steps, with the bound of Collatz and Wielandt."""
    n = len(a)
    v = np.ones(n)
    best = np.inf
    for _ in range(40):
        w = np.zeros(n)
        for i in range(n):
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
def expm1_levels(a: Array, step: float, out: Array) -> None:
    """out[k] (n, n) = transpose of exp(A step / 2^k) - 1, for k from 0 to len(out) - 1.

    The shortest step is summed as a series, each doubling is F -> 2 F + F F. Kept without the
    identity, a doubling adds an error relative to F alone, so that short steps lose nothing.
    """
    n, levels = len(a), len(out)
    rate = growth_rate(a) * step
    halvings = levels - 1
    while rate * 0.5**halvings > 0.02:
        halvings += 1
    h = step * 0.5**halvings
    f = np.zeros((n, n))
    term = np.eye(n)
    for k in range(1, TERMS + 1):
        term = term @ a * (h / k)
        f += term
    for k in range(halvings, -1, -1):
        if k < levels:
            for i in range(n):
                for j in range(n):
                    out[k, j, i] = f[i, j]
        if k:
            f = 2.0 * f + f @ f


def legendre(count: int) -> tuple[Array, Array]:
    """Points and weights of Gauss and Legendre on (0, 1)."""
    points, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 + 0.5 * points, 0.5 * weights


def exponential(a: Array, step: float) -> Array:
    """exp(A step), (n, n)."""
    out = np.zeros((1, *a.shape))
    expm1_levels(a, step, out)
    return np.asarray(out[0].T + np.eye(len(a)))


@compiled
def bound_of_exponential(a: Array, delta: float) -> Array:
    """(n, n) B with |exp(A t)| <= B entry by entry for 0 <= t <= delta: exp(|A| delta), rounded up."""
    n = len(a)
    size = np.abs(a)
    total = np.eye(n)
    term = np.eye(n)
    for k in range(1, 30):
        term = term @ size * (delta / k)
        total += term
    return total * (1.0 + 1e-9)


@compiled
def largest_rows(rows: Array, a: Array, step: float) -> Array:
    """(m, n) R with |(rows exp(A t))_ij| <= R_ij for 0 <= t <= step: sampled, and bounded between samples."""
    m, n = rows.shape
    samples = 1
    rate = growth_rate(a) * step
    while rate / samples > 0.25:
        samples *= 2
    delta = step / samples
    f = np.zeros((1, n, n))
    expm1_levels(a, delta, f)
    forward = f[0].T.copy()
    most = np.abs(rows)
    now = rows.copy()
    for _ in range(samples - 1):
        now = now + now @ forward
        for i in range(m):
            for j in range(n):
                most[i, j] = max(most[i, j], abs(now[i, j]))
    return most @ bound_of_exponential(a, delta)
