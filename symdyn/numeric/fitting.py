"""Fitting the parameters of a model to a recording by Gauss-Newton on inverse dynamics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from symdyn.base.errors import NumericalError, Problem
from symdyn.numeric.regression import LinearFit, fit_linear, solve_bounded
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

MAX_ITERATIONS = 50
SETTLED = 1e-7  # relative fall of the loss below which a fit has settled
CREEPING = 1e-4  # a fall that small after all iterations: a valley which the recording does not tell from its floor


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """``p`` is the whole parameter vector; ``names`` those that were fitted, in the order of ``last``."""

    names: tuple[str, ...]
    p: Array
    last: LinearFit  # of the final iteration: covariance at the solution

    def standard_error(self, name: str) -> float | None:
        """None where the recording does not tell this parameter by itself."""
        i = self.names.index(name)
        return float(self.last.standard_error[i]) if self.last.identifiable[i] else None


Bounds = Mapping[str, tuple[float, float]]


def fit(bench: Workbench, p: Array, names: Sequence[str], weight: Array, bounds: Bounds | None = None) -> Fit:
    """Minimise the weighted residual over the named parameters, starting from ``p``.

    ``weight`` (n,) per joint. Directions that the recording does not excite keep their start values.
    Inverse dynamics is linear in most parameters, so one or two iterations are the rule. ``bounds``
    holds (lower, upper) of the parameters that have any: a mass is not negative, whatever fits.

    Raises NumericalError (SD612) if the iteration does not settle.
    """
    p = p.copy()
    if not names:
        empty = LinearFit(np.zeros(0), np.zeros((0, 0)), np.zeros(0, dtype=bool))
        return Fit((), p, empty)
    where = [bench.index[name] for name in names]
    size = _sizes(p[where])
    limits = bounds or {}
    lower = np.array([limits.get(name, (-np.inf, np.inf))[0] for name in names])
    upper = np.array([limits.get(name, (-np.inf, np.inf))[1] for name in names])
    previous = _loss(bench.residual(p), weight)
    for _ in range(MAX_ITERATIONS):
        columns, target = bench.columns(p, names) * weight[:, None], bench.residual(p) * weight
        step = solve_bounded(columns, target, size, lower - p[where], upper - p[where])
        p, loss = _line_search(bench, p, where, step, weight, previous)
        fall, previous = previous - loss, loss
        if fall <= SETTLED * previous:
            break
    else:
        if fall > CREEPING * previous:
            p = _trust_region(bench, p, names, where, weight, size, (lower, upper))
    last = fit_linear(bench.columns(p, names) * weight[:, None], bench.residual(p) * weight)
    return Fit(tuple(names), p, last)


def _trust_region(
    bench: Workbench,
    p: Array,
    names: Sequence[str],
    where: Sequence[int],
    weight: Array,
    size: Array,
    limits: tuple[Array, Array],
) -> Array:
    """What Gauss-Newton does not settle: parameters that appear as products, in a model that lacks something."""

    def at(x: Array) -> Array:
        moved = p.copy()
        moved[where] = x
        return moved

    def residual(x: Array) -> Array:
        return (bench.residual(at(x)) * weight).ravel()

    def jacobian(x: Array) -> Array:
        return -(bench.columns(at(x), names) * weight[:, None]).reshape(-1, len(names))

    start = np.clip(p[where], *limits)
    solution = optimize.least_squares(residual, start, jac=jacobian, bounds=limits, x_scale=size, ftol=SETTLED)
    if not solution.success:
        message = f"the fit of {', '.join(names)} did not settle: {solution.message}"
        raise NumericalError(Problem("SD612", message))
    return at(solution.x)


def _line_search(
    bench: Workbench, p: Array, where: Sequence[int], step: Array, weight: Array, previous: float
) -> tuple[Array, float]:
    """The longest of the step's halvings that does not raise the loss; none at all when none does."""
    scale = 1.0
    while scale > 1e-4:
        trial = p.copy()
        trial[where] += scale * step
        loss = _loss(bench.residual(trial), weight)
        if loss <= previous:
            return trial, loss
        scale /= 2.0
    return p, previous


def _sizes(values: Array) -> Array:
    """Natural sizes of parameters: their values, so that what the data do not tell stays in proportion."""
    sizes = np.abs(values)
    return np.where(sizes > 0, sizes, max(float(sizes.max(initial=0.0)), 1.0))


def joint_weight(residual: Array, effort: Array) -> Array:
    """(n,) one over the residual's size per joint, so that joints of all sizes count alike."""
    size = np.sqrt(np.mean(residual**2, axis=0))
    floor = 1e-6 * np.sqrt(np.mean(effort**2, axis=0)) + 1e-300
    return np.asarray(1.0 / np.maximum(size, floor))


def relative_error(residual: Array, effort: Array) -> float:
    """Size of the residual over that of the measured effort; joints count alike (root mean square)."""
    power = np.sum(effort**2, axis=0)
    share = np.divide(np.sum(residual**2, axis=0), power, out=np.zeros_like(power), where=power > 0)
    return float(np.sqrt(np.mean(share)))


def _loss(residual: Array, weight: Array) -> float:
    return float(np.sum((residual * weight) ** 2))
