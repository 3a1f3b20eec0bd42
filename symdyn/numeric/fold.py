"""A least-squares problem folded into triangles: per joint a few rows that hold all that its samples say."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.regression import triangle
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]


class Problem(Protocol):
    """What a fit needs: parameters are those of the kernel, then the coefficients of added columns."""

    def residual(self, x: Array) -> Array: ...  # (m, n)

    def columns(self, x: Array) -> Array: ...  # (m, n, k) of what is fitted


class Plain:
    """Evaluated on every sample."""

    def __init__(self, bench: Workbench, names: Sequence[str], added: Array) -> None:
        self.bench, self.names, self.added = bench, list(names), added
        self.size = len(bench.kernel.parameters)

    def residual(self, x: Array) -> Array:
        return self.bench.residual(x[: self.size]) - np.asarray(self.added @ x[self.size :])

    def columns(self, x: Array) -> Array:
        return np.concatenate([self.bench.columns(x[: self.size], self.names), self.added], axis=2)


class Folded:
    """The same sums of squares, from factors of the columns; exact where the model lies in its span.

    The span's columns, and the residual at its start, are factored once for a bench: of added columns, which are others
    in every fit, the part beyond them is left, and of those only what acts at a joint.
    """

    def __init__(self, bench: Workbench, names: Sequence[str], added: Array) -> None:
        self.names, self.index, self.size = list(names), bench.index, len(bench.kernel.parameters)
        self.span, fixed = bench.span(names)
        self.fixed, count = fixed.shape[2], added.shape[2]
        parts = [self._at(factors, added[:, j]) for j, factors in enumerate(bench.factors(names))]
        self._rows = np.zeros((max(len(part) for part in parts), len(parts), self.fixed + count + 1))
        for j, part in enumerate(parts):
            self._rows[: len(part), j] = part

    def _at(self, factors: tuple[Array, Array], added: Array) -> Array:
        """(m, fixed + e + 1) rows of one joint: the span's columns, those that are added, the residual at the start."""
        basis, known = factors
        acting = np.flatnonzero(np.any(added, axis=0))
        held = basis.T @ added[:, acting]
        beyond = triangle(added[:, acting] - basis @ held)
        rows = np.zeros((len(known) + len(beyond), self.fixed + added.shape[1] + 1))
        rows[: len(known), : self.fixed], rows[: len(known), -1] = known[:, :-1], known[:, -1]
        rows[: len(known), self.fixed + acting], rows[len(known) :, self.fixed + acting] = held, beyond
        return rows

    def residual(self, x: Array) -> Array:
        t = self._rows
        own = t[:, :, : self.fixed] @ self.span.coefficients(x[: self.size])
        return np.asarray(t[:, :, -1] - own - t[:, :, self.fixed : -1] @ x[self.size :])

    def columns(self, x: Array) -> Array:
        t = self._rows
        own = t[:, :, : self.fixed] @ self.span.slopes(x[: self.size], self.names, self.index)
        return np.concatenate([own, t[:, :, self.fixed : -1]], axis=2)
