"""Copies of matrices as loops: of array expressions Numba takes seconds to compile each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled

Array = NDArray[np.float64]


@compiled
def copy(source: Array, out: Array) -> None:
    """out[:m, :n] = source (m, n)."""
    for i in range(len(source)):
        for j in range(source.shape[1]):
            out[i, j] = source[i, j]


@compiled
def copy_row(source: Array, of: int, times: int, out: Array, row: int) -> None:
    """out[row] = times * source[of]."""
    for j in range(out.shape[1]):
        out[row, j] = times * source[of, j]


@compiled
def transpose(source: Array, out: Array, at: int) -> None:
    """out[:n, at : at + m] = the transpose of ``source`` (m, n)."""
    m, n = source.shape
    for i in range(n):
        for j in range(m):
            out[i, at + j] = source[j, i]


@compiled
def absolute(source: Array) -> Array:
    """|source|, entry by entry."""
    found = np.empty(source.shape)
    for i in range(len(source)):
        for j in range(source.shape[1]):
            found[i, j] = abs(source[i, j])
    return found
