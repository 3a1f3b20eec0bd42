"""A free-form force on top of the model, one value per cell, the model refitted around it (Frisch, Waugh, Lovell)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.conditions import Condition
from symdyn.numeric.decomposition import svd
from symdyn.numeric.explanation import Case, Explanation
from symdyn.numeric.regression import RANK_TOLERANCE, flat

Array = NDArray[np.float64]

FOLDS = 4  # contiguous
RIDGE = 1e-3  # of the usual weight of a cell


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """Columns (K, n, k) of what was fitted, on training and on held-out data, and the ``weight`` (n,) of each joint."""

    training: Array
    heldout: Array
    weight: Array
    joints: Sequence[str]


def fitted_of(case: Case, of: Explanation) -> Fitted:
    """Everything that an explanation fitted: the model's own parameters, and those of the effects found."""
    return Fitted(of.design, case.design(case.judged, of), of.weight, case.joints)


class FreeForm:
    """Makes the columns of a condition's cells, less what the model's own parameters make of them."""

    def __init__(self, fitted: Fitted) -> None:
        self._training, self._heldout = (
            columns * fitted.weight[:, None] for columns in (fitted.training, fitted.heldout)
        )
        design = flat(self._training)
        size = np.linalg.norm(design, axis=0)
        scale = np.where(size > 0.0, size, 1.0)
        u, s, vt = svd(design / scale, full_matrices=False)
        keep = s > RANK_TOLERANCE * s.max(initial=0.0)
        # (k, K, n): what a unit of effort at each sample does to the parameters
        inverse = (vt[keep].T / s[keep]) @ u[:, keep].T / scale[:, None]
        self._inverse = inverse.reshape(-1, *self._training.shape[:2])

    def columns(self, condition: Condition, j: int) -> Columns:
        """Of a force at joint ``j`` that has one value in each cell, in units of the joint's weight."""
        inverse = self._inverse[:, :, j]
        share = [np.bincount(condition.training, row, minlength=condition.cells) for row in inverse]
        moved = np.stack(share) if share else np.zeros((0, condition.cells))  # (k, cells)
        made: list[Array] = []
        for cell, base in ((condition.training, self._training), (condition.heldout, self._heldout)):
            column: Array = -(base @ moved)
            column[np.arange(len(cell)), j, cell] += 1.0
            made.append(column)
        return Columns(made[0], made[1])

    def forces(self, training: Array, heldout: Array) -> Columns:
        """Of one pattern of weighted efforts, (K, n) each."""
        moved = np.einsum("kij,ij->k", self._inverse, training)
        return Columns((training - self._training @ moved)[:, :, None], (heldout - self._heldout @ moved)[:, :, None])


@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """(K, n, cells) of training and of held-out data, weighted."""

    training: Array
    heldout: Array

    def cross_validated_gain(self, residual: Array) -> float:
        """Fall of the mean square of ``residual`` (K, n), each contiguous fold predicted from the others."""
        parts = np.array_split(np.arange(len(residual)), FOLDS)
        grams, targets = [], []
        for part in parts:
            column = self.training[part].reshape(-1, self.training.shape[2])
            grams.append(column.T @ column)
            targets.append(column.T @ residual[part].reshape(-1))
        whole, target = sum(grams), sum(targets)
        gain = 0.0
        for gram, seen in zip(grams, targets, strict=True):
            value = _solve(whole - gram, target - seen)
            gain += float(2.0 * value @ seen - value @ gram @ value)
        return gain / len(residual)

    def taken_out(self, training: Array, heldout: Array) -> tuple[Array, Array]:
        """The residuals without what the cells tell of the training data."""
        column = self.training.reshape(-1, self.training.shape[2])
        value = _solve(column.T @ column, column.T @ training.reshape(-1))
        return training - self.training @ value, heldout - self.heldout @ value


def _solve(gram: Array, target: Array) -> Array:
    """Least squares, shrunk a little: cells that are nearly the model's own, or nearly empty, take nothing."""
    ridge = RIDGE * float(np.trace(gram)) / len(gram) + 1e-300
    return np.asarray(np.linalg.solve(gram + ridge * np.eye(len(gram)), target))
