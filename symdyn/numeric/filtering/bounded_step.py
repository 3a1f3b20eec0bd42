"""The step down a parabola that stays within bounds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import lsq_linear

from symdyn.numeric.decomposition import least_squares

Array = NDArray[np.float64]


def bounded_step(normal: Array, slope: Array, lower: Array, upper: Array) -> Array:
    """(k,) where x . slope - x . normal x / 2 is largest within these bounds; ``normal`` (k, k) is positive definite.

    Not the free step cut off: its parts make up for each other, and what is left of them may lead uphill.
    """
    step: Array = least_squares(normal, slope, rcond=1e-14)
    if np.all((step >= lower) & (step <= upper)):
        return step
    root = np.linalg.cholesky(normal)
    towards = solve_triangular(root, slope, lower=True)
    return np.asarray(lsq_linear(root.T, towards, (lower, upper), method="bvls").x)
