"""(s E - F)^-1 for many s at once: one QZ factorisation, then back substitution across all frequencies.

Backward stable where a sum over modes is not (close or defective poles), and indifferent to a singular E.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from symdyn.base.linear_system import Array, LinearSystem

Complex = NDArray[np.complex128]

BLOCK = 2048  # frequencies that are worked on together: they stay in the second cache
_RATE = 1e3  # rad/s at which E and F are weighed against each other when they are scaled
_ROUNDS = 3


def laplace(hertz: Array) -> Complex:
    """s = j 2 pi f."""
    return np.asarray(2j * np.pi * hertz, np.complex128)


@dataclass(frozen=True, slots=True, eq=False)
class Resolvent:
    """``rows (s E - F) columns = Q (s T_E - T_F) Z^H`` with triangular T; rows and columns are scales (nx,)."""

    rows: Array
    columns: Array
    te: Complex
    tf: Complex
    q: Complex
    z: Complex

    @classmethod
    def of(cls, system: LinearSystem) -> Resolvent:
        rows, columns = scales(system.e, system.f)
        both = np.outer(rows, columns)
        tf, te, q, z = linalg.qz(system.f * both, system.e * both, output="complex")
        triangular = (np.asarray(matrix, np.complex128) for matrix in (te, tf, q, z))
        return cls(rows, columns, *triangular)

    def right(self, s: Complex, b: Array) -> Complex:
        """(nx, number of s): (s E - F)^-1 b."""
        given = self.q.conj().T @ (self.rows * b)
        found = _back(self.te, self.tf, s, given)
        return self.columns[:, None] * (self.z @ found)

    def left(self, s: Complex, c: Array) -> Complex:
        """(nx, number of s): the rows c (s E - F)^-1, as columns."""
        given = (self.columns * c) @ self.z
        found = _back(self.te[::-1, ::-1].T, self.tf[::-1, ::-1].T, s, given[::-1])[::-1]
        return self.rows[:, None] * (self.q.conj() @ found)

    def apply(self, s: Complex, c: Array, column: Array) -> Complex:
        """(number of s,): c (s E - F)^-1 column, in blocks."""
        given = self.q.conj().T @ (self.rows * column)
        seen = (self.columns * c) @ self.z
        blocks = (s[i : i + BLOCK] for i in range(0, len(s), BLOCK))
        # einsum, not @: for sums this short the threads of a BLAS cost more than they save
        return np.concatenate([np.einsum("i,ij->j", seen, _back(self.te, self.tf, b, given)) for b in blocks])


def scales(e: Array, f: Array) -> tuple[Array, Array]:
    """Powers of two for rows and columns that bring the rows and columns of |F| + rate |E| to size 1."""
    size = f**2 + (_RATE * e) ** 2
    rows, columns = np.ones(len(e)), np.ones(len(e))
    for _ in range(_ROUNDS):
        for axis, own in ((1, rows), (0, columns)):
            total = (size * np.outer(rows, columns) ** 2).sum(axis=axis)
            own /= np.where(total > 0, total, 1.0) ** 0.25
    return np.exp2(np.round(np.log2(rows))), np.exp2(np.round(np.log2(columns)))


def _back(te: Complex, tf: Complex, s: Complex, given: Complex) -> Complex:
    """x (nx, number of s) with (s te - tf) x = given, te and tf upper triangular; infinite at a pole."""
    n = len(given)
    x = np.empty((n, len(s)), np.complex128)
    with np.errstate(divide="ignore", invalid="ignore"):
        for i in range(n - 1, -1, -1):
            right = np.full(len(s), given[i])
            for j in range(i + 1, n):
                right += (tf[i, j] - s * te[i, j]) * x[j]
            x[i] = right / (s * te[i, i] - tf[i, i])
    return x
