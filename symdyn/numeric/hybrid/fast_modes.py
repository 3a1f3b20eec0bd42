"""The fast motions of a linear system, apart from the rest: so that they are not counted where they are at rest."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled
from symdyn.numeric.hybrid.vectors import LANES, solve

Array = NDArray[np.float64]

GAP = 1.5  # between the magnitudes of what is fast and what is not
SLOWEST = 0.5  # magnitude times the step from which on it matters
WORST = 1e8  # of the projector's entries: beyond, it would amplify rounding


@compiled
def fast_motions(a: Array, step: float) -> Any:
    """(R, L), (n, 8) and (8, n), zero where there are fewer: of z, the fast motions are R L z.

    R spans an invariant subspace of A, L one of its transpose, and L R = 1, to rounding. What is built on them
    must not rely on that: z = R L z + (1 - R L) z holds for any.
    """
    n = len(a)
    right, left = np.zeros((n, LANES)), np.zeros((LANES, n))
    values, vectors = np.linalg.eig(a.astype(np.complex128))
    sizes = np.sort(np.abs(values))[::-1]
    count = 0
    for k in range(1, min(LANES, n - 1) + 1):
        if sizes[k - 1] * step > SLOWEST and sizes[k - 1] > GAP * sizes[k]:
            count = k
    if count == 0:
        return right, left
    cut = sizes[count - 1] * (1.0 - 1e-6)
    found = _real_basis(values, vectors, cut, right)
    values, vectors = np.linalg.eig(a.T.astype(np.complex128))
    spare = np.zeros((n, LANES))
    if found != count or _real_basis(values, vectors, cut, spare) != count:
        return np.zeros((n, LANES)), left
    product = np.zeros((count, count))
    part = np.zeros((count, n))
    for r in range(count):
        for i in range(n):
            part[r, i] = spare[i, r]
            for c in range(count):
                product[r, c] += spare[i, r] * right[i, c]
    solve(product, part, count)
    worst = 0.0
    for r in range(count):
        for i in range(n):
            worst = max(worst, abs(part[r, i]))
    if not worst < WORST:
        return np.zeros((n, LANES)), left
    left[:count] = part
    return right, left


@compiled
def _real_basis(values: Any, vectors: Any, cut: float, out: Array) -> int:
    """Real and imaginary parts of the eigenvectors whose values are at least ``cut`` in magnitude; how many."""
    count = 0
    for k in range(len(values)):
        if abs(values[k]) < cut or values[k].imag < -1e-9 * cut:
            continue
        both = values[k].imag > 1e-9 * cut
        if count + 1 + both > out.shape[1]:
            return -1
        out[:, count] = vectors[:, k].real
        if both:
            out[:, count + 1] = vectors[:, k].imag
        count += 1 + both
    return count
