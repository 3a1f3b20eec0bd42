"""Inverse dynamics of a model as a sum of fixed columns: found numerically, so that fits need not touch samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from symdyn.emit.kernel import Kernel
from symdyn.numeric.decomposition import pseudo_inverse

Array = NDArray[np.float64]

STATES = 400  # of the recording, on which coefficients are found
POINTS = 4  # of parameters beside the given ones, at most, where columns are collected
SPREAD = 0.5  # of those points about the given values
SMALL = 1e-2  # of the largest: what is smaller, or nothing yet, is moved there, and shows what it multiplies
EXACT = 1e-9  # relative error beyond which the sum is not the model
SAME = 1e-9  # part of a column that the others must leave for it to count


@dataclass(frozen=True, slots=True, eq=False)
class Span:
    """ID(p) = ID(start) + columns . coefficients(p), exactly, for models that are linear in functions of p.

    Inertial parameters enter by products (m, m c, I + m c^2), most others by themselves; the products
    are not told by anyone: derivatives at a few parameter vectors span what they span.
    """

    kernel: Kernel
    names: tuple[str, ...]
    start: Array
    sources: tuple[tuple[int, int], ...]  # of each column: parameter vector, index into names
    points: tuple[Array, ...]
    motion: tuple[Array, Array, Array]  # of the chosen states
    at_start: Array  # inverse dynamics there, flat
    inverse: Array  # (r, M n) of the columns there
    exact: bool  # whether the sum is the model, with its slopes, at parameter vectors that were not used to find it

    def coefficients(self, p: Array) -> Array:
        """(r,)"""
        return np.asarray(self.inverse @ self._change(p))

    def slopes(self, p: Array, names: Sequence[str], index: dict[str, int]) -> Array:
        """(r, k) d coefficients / d parameter."""
        jacobian = self.kernel.rows("inverse_dynamics_parameter_jacobian_p", *self.motion, p)
        chosen = jacobian[:, :, [index[name] for name in names]]
        return np.asarray(self.inverse @ chosen.reshape(-1, len(names)))

    def _change(self, p: Array) -> Array:
        return np.asarray(self.kernel.rows("inverse_dynamics_p", *self.motion, p).reshape(-1) - self.at_start)


def find_span(kernel: Kernel, names: Sequence[str], index: dict[str, int], motion: tuple[Array, Array, Array]) -> Span:
    """The span of a model's own parameters over a recording's ``motion`` (q, qd, qdd), each (N, n)."""
    start = kernel.values
    rng = np.random.default_rng(len(names))
    rows = np.sort(rng.permutation(len(motion[0]))[:STATES])
    chosen = (motion[0][rows], motion[1][rows], motion[2][rows])
    where = [index[name] for name in names]
    side, size = np.where(start[where] < 0, -1.0, 1.0), np.abs(start[where])
    size = np.where(size > 0, size, max(float(size.max(initial=0.0)), 1.0))
    large = np.maximum(size, SMALL * size.max(initial=0.0))

    def moved(to: Array) -> Array:
        point = start.copy()
        point[where] = side * to * rng.uniform(1.0 - SPREAD, 1.0 + SPREAD, len(where))  # a negative width is none
        return point

    points, others = [start], [moved(size), moved(large)]
    at_start = kernel.rows("inverse_dynamics_p", *chosen, start).reshape(-1)
    asked = [kernel.rows("inverse_dynamics_p", *chosen, other).reshape(-1, 1) - at_start[:, None] for other in others]
    asked += [_columns(kernel, chosen, other, where) for other in others]
    collected, exact = [_columns(kernel, chosen, start, where)], False
    while not exact and len(points) <= POINTS:
        points.append(moved(large))
        collected.append(_columns(kernel, chosen, points[-1], where))
        stacked = np.concatenate(collected, axis=1)
        kept, inverse = _basis(stacked)
        exact = all(
            bool(np.all(np.linalg.norm(x - stacked[:, kept] @ (inverse @ x), axis=0) <= EXACT * np.linalg.norm(x)))
            for x in asked
        )
    sources = tuple((int(i) // len(where), int(i) % len(where)) for i in kept)
    return Span(kernel, tuple(names), start, sources, tuple(points), chosen, at_start, inverse, exact)


def _columns(kernel: Kernel, motion: tuple[Array, Array, Array], p: Array, where: Sequence[int]) -> Array:
    """(M n, k) d inverse dynamics / d parameter; nothing where that is none."""
    jacobian = kernel.rows("inverse_dynamics_parameter_jacobian_p", *motion, p)
    chosen = jacobian[:, :, where].reshape(-1, len(where))
    return np.asarray(np.where(np.isfinite(chosen), chosen, 0.0))


def _basis(stacked: Array) -> tuple[Array, Array]:
    """(r,) columns that span all of them, and (r, M n) what gives their coefficients."""
    length = np.linalg.norm(stacked, axis=0)
    moving = np.flatnonzero(length > 0)
    _, triangle, order = linalg.qr(stacked[:, moving] / length[moving], mode="economic", pivoting=True)
    diagonal = np.abs(np.diag(triangle))
    kept = np.sort(moving[order[: int(np.sum(diagonal > SAME * diagonal.max(initial=0.0)))]])
    scale = length[kept]
    return kept, pseudo_inverse(stacked[:, kept] / scale, rcond=1e-12) / scale[:, None]
