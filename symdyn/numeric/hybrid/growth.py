"""How large an output of a linear system can become over a step: bounds for its derivatives."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled
from symdyn.numeric.hybrid.exponential import bound_of_exponential, expm1_levels
from symdyn.numeric.hybrid.loops import absolute, copy
from symdyn.numeric.hybrid.vectors import LANES, matrix_product

Array = NDArray[np.float64]

COARSEST = 1.0  # between samples, times the growth rate
UNSEEN = 1e-13  # rounding of a sample, relative to its terms


@compiled
def largest_rows(rows: Array, a: Array, rate: float, step: float, right: Array, left: Array) -> Array:
    """(m, 8 + n) B with |rows exp(A t) z| <= B |[L z; z]| for 0 <= t <= step.

    z = R L z + (1 - R L) z = V [L z; z] with V = [R, 1 - R L]. Where R and L are fast motions, those of a slow z
    cancel in the second part. Sampled; between samples x is within delta^2 |x''| / 8 of the chord, and
    x'' = rows A^2 exp(A t) V of its sample times exp(|W| delta), with A V = V W: what is missing there is counted.
    """
    m, n = rows.shape
    w = LANES + n
    samples = 1
    while rate * step / samples > COARSEST:
        samples *= 2
    delta = step / samples
    parts, within, residual = _split(a, right, left)
    forward = np.zeros((1, n, n))
    expm1_levels(a, rate, delta, forward)
    now, change, seen = np.empty((2 * m, n)), np.empty((2 * m, n)), np.empty((2 * m, w))
    copy(rows, now)
    matrix_product(now[:m], a, change[:m])
    matrix_product(change[:m], a, now[m:])
    most, terms = np.zeros((2 * m, w)), np.zeros((2 * m, n))
    for k in range(samples + 1):
        matrix_product(now, parts, seen)
        for i in range(2 * m):
            for j in range(w):
                most[i, j] = max(most[i, j], abs(seen[i, j]))
            for j in range(n):
                terms[i, j] = max(terms[i, j], abs(now[i, j]))
        if k < samples:
            matrix_product(now, forward[0], change)
            for i in range(2 * m):
                for j in range(n):
                    now[i, j] += change[i, j]
    inside, outside = bound_of_exponential(within, delta), bound_of_exponential(a, delta)
    missing, largest, share = np.empty((n, w)), np.empty((n, w)), np.empty((m, w))
    matrix_product(outside, residual, missing)
    matrix_product(missing, inside, largest)
    bounds = np.empty((m, w))
    for i in range(n):
        for j in range(w):
            largest[i, j] *= delta
    matrix_product(terms[m:], largest, share)
    for i in range(m):
        for j in range(w):
            most[m + i, j] += share[i, j]
    matrix_product(most[m:], inside, bounds)
    matrix_product(terms[:m], absolute(parts), share)
    for i in range(m):
        for j in range(w):
            bounds[i, j] = most[i, j] + delta * delta / 8.0 * bounds[i, j] + UNSEEN * share[i, j]
    return bounds


@compiled
def _split(a: Array, right: Array, left: Array) -> tuple[Array, Array, Array]:
    """V (n, 8 + n), W and |A V - V W|, the last rounded up."""
    n = len(a)
    w = LANES + n
    parts, within = np.zeros((n, w)), np.zeros((w, w))
    rest, rates = np.empty((n, n)), np.empty((LANES, n))
    matrix_product(right, left, rest)
    copy(right, parts)
    for i in range(n):
        for j in range(n):
            parts[i, LANES + j] = (1.0 if i == j else 0.0) - rest[i, j]
    slow = np.empty((LANES, LANES))
    matrix_product(left, a, rates)
    matrix_product(rates, right, slow)
    copy(slow, within)
    for i in range(n):
        for j in range(n):
            within[LANES + i, LANES + j] = a[i, j]
    one, two, residual = np.empty((n, w)), np.empty((n, w)), np.empty((n, w))
    matrix_product(a, parts, one)
    matrix_product(parts, within, two)
    for i in range(n):
        for j in range(w):
            residual[i, j] = abs(one[i, j] - two[i, j])
    matrix_product(absolute(a), absolute(parts), one)
    for i in range(n):
        for j in range(w):
            residual[i, j] += 1e-15 * one[i, j]
    return parts, within, residual
