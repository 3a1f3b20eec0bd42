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
    """The same sums of squares, from triangular factors; exact where the model lies in its span."""

    def __init__(self, bench: Workbench, names: Sequence[str], added: Array) -> None:
        self.names, self.index, self.size = list(names), bench.index, len(bench.kernel.parameters)
        self.span, fixed = bench.span(names)
        self.fixed, count = fixed.shape[2], added.shape[2]
        start = bench.left(self.span.start, names)
        rows = self.fixed + count + 1
        self._triangles = np.zeros((rows, start.shape[1], rows))
        for j in range(start.shape[1]):
            stacked = np.concatenate([fixed[:, j], added[:, j], start[:, [j]]], axis=1)
            folded = triangle(stacked)
            self._triangles[: len(folded), j] = folded

    def residual(self, x: Array) -> Array:
        t = self._triangles
        own = t[:, :, : self.fixed] @ self.span.coefficients(x[: self.size])
        return np.asarray(t[:, :, -1] - own - t[:, :, self.fixed : -1] @ x[self.size :])

    def columns(self, x: Array) -> Array:
        t = self._triangles
        own = t[:, :, : self.fixed] @ self.span.slopes(x[: self.size], self.names, self.index)
        return np.concatenate([own, t[:, :, self.fixed : -1]], axis=2)
