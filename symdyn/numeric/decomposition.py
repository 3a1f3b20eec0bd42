"""Singular values, least squares and pseudo-inverses that never fail on finite numbers.

LAPACK's divide and conquer, NumPy's choice, does not converge on some matrices of low rank; its plain iteration does.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

Array = NDArray[np.float64]


def svd(a: Array, *, full_matrices: bool = True) -> tuple[Array, Array, Array]:
    """(u, s, vt) of a (m, n), as ``numpy.linalg.svd``."""
    try:
        return np.linalg.svd(a, full_matrices=full_matrices)
    except np.linalg.LinAlgError:
        u, s, vt = linalg.svd(a, full_matrices=full_matrices, lapack_driver="gesvd")
        return u, s, vt


def least_squares(a: Array, b: Array, rcond: float | None = None) -> Array:
    """x of least size that minimises |a x - b|; directions below ``rcond`` (of the largest one) stay at zero."""
    try:
        return np.asarray(np.linalg.lstsq(a, b, rcond=rcond)[0])
    except np.linalg.LinAlgError:
        found: Any = linalg.lstsq(a, b, cond=rcond, lapack_driver="gelss")
        return np.asarray(found[0])


def pseudo_inverse(a: Array, rcond: float = 1e-15) -> Array:
    """(n, m) of a (m, n), as ``numpy.linalg.pinv``."""
    u, s, vt = svd(a, full_matrices=False)
    keep = s > rcond * s.max(initial=0.0)
    return np.asarray((vt[keep].T / s[keep]) @ u[:, keep].T)
