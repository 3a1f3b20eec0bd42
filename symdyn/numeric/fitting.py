"""Fitting the parameters of a model to a recording by Gauss-Newton on inverse dynamics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from symdyn.base import errors
from symdyn.base.errors import NumericalError
from symdyn.numeric.fold import Folded, Plain, Problem
from symdyn.numeric.regression import LinearFit, fit_linear, solve_bounded
from symdyn.numeric.sizes import sized
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

MAX_ITERATIONS = 50
SETTLED = 1e-7  # relative fall of the loss below which a fit has settled
CREEPING = 1e-4  # a fall that small after all iterations: a valley which the recording does not tell from its floor
EVALUATIONS = 200  # of a trust region, after which it may be creeping, too


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
Sizes = Mapping[str, float]


def fit(
    bench: Workbench,
    p: Array,
    names: Sequence[str],
    weight: Array,
    bounds: Bounds | None = None,
    sizes: Sizes | None = None,
) -> Fit:
    """Minimise the weighted residual over the named parameters, starting from ``p``.

    ``weight`` (n,) per joint. Directions that the recording does not excite keep their start values.
    Inverse dynamics is linear in most parameters, so one or two iterations are the rule. ``bounds``
    holds (lower, upper) of the parameters that have any: a mass is not negative, whatever fits; ``sizes`` those of
    which the values do not tell it.

    Raises NumericalError (SD612) if the iteration does not settle.
    """
    if not names:
        return Fit((), p.copy(), LinearFit(np.zeros(0), np.zeros((0, 0)), np.zeros(0, dtype=bool)))
    none = np.zeros((*bench.effort.shape, 0))
    p, _, _ = minimise(bench, p, names, none, np.zeros(0), [], weight, bounds or {}, sizes or {})
    residual, columns = bench.residual(p), bench.columns(p, names)
    if bench.passive.joints:
        columns = columns + eased(bench, p, names, residual)
    last = fit_linear(columns * weight[:, None], residual * weight)
    return Fit(tuple(names), p, last)


def minimise(
    bench: Workbench,
    p: Array,
    names: Sequence[str],
    added: Array,
    start: Array,
    added_names: Sequence[str],
    weight: Array,
    bounds: Bounds,
    sizes: Sizes,
    spread: float = np.inf,
    unknown: frozenset[str] = frozenset(),
    weighed: Array | None = None,
    steps: int | None = None,
) -> tuple[Array, Array, bool]:
    """The fit itself, with ``added`` columns (K, n, e) beside the kernel's parameters: (p, their coefficients, ended).

    ``spread``: standard deviation, as a share of their ``sizes`` (of their values where those are not told), that the
    kernel's own parameters are thought to have in the model as given. Wide as it is, it decides along directions that
    a recording hardly tells. Of ``unknown`` ones nothing is thought but their size, where that is told. ``weighed``:
    parameters at which residuals have the size that the weights are for, those of the start if None; what no effort
    drives has it from the inertia (``Passive``). ``steps``, if given: it stops where it is after so many. Without,
    ``ended`` says whether it settled before all iterations were used up.
    """
    where = [*(bench.index[name] for name in names), *range(len(p), len(p) + len(start))]
    x0 = np.concatenate([p, start])
    if not where:
        return p.copy(), start.copy(), True
    wanted = [bounds.get(name, (-np.inf, np.inf)) for name in (*names, *added_names)]
    limits = np.array([b[0] for b in wanted]), np.array([b[1] for b in wanted])
    given = bench.kernel.values
    held = np.delete(p != given, where[: len(names)]).any()  # a span is about the kernel's own values
    problem: Problem = Plain(bench, names, added) if held or not bench.foldable(names) else Folded(bench, names, added)
    given = given[where[: len(names)]]
    own = np.array([0.0 if name in unknown and name not in sizes else 1.0 for name in names])
    pull = np.concatenate([own / (spread * sized(names, given, sizes)), np.zeros(len(start))])
    thought = np.concatenate([given, start])
    if bench.passive.joints:
        problem = _Sized(problem, bench, names, bench.passive.inertia(p if weighed is None else weighed))
    size = sized([*names, *added_names], x0[where], sizes)
    x, ended = _minimise(_Weighted(problem, x0, where, weight, thought, pull), limits, size, steps)
    return x[: len(p)], x[len(p) :], ended


def eased(bench: Workbench, p: Array, names: Sequence[str], residual: Array) -> Array:
    """(K, n, k) what columns of parameters lack where a residual (K, n) is a passive joint's.

    A larger inertia makes its residual larger: that is none of what the residual says.
    """
    return np.asarray(residual[:, :, None] * bench.passive.slopes(p, names))


@dataclass(frozen=True, slots=True, eq=False)
class _Sized:
    """A problem in which the residuals of passive joints are in proportion to accelerations."""

    problem: Problem
    bench: Workbench
    names: Sequence[str]
    inertia: Array  # (n,) for which the residual is as it is

    def residual(self, x: Array) -> Array:
        return self.problem.residual(x) * self._scale(x)

    def columns(self, x: Array) -> Array:
        columns = self.problem.columns(x).copy()
        residual, count = self.problem.residual(x), len(self.names)
        columns[:, :, :count] += eased(self.bench, self._own(x), self.names, residual)
        return np.asarray(columns * self._scale(x)[:, None])

    def _scale(self, x: Array) -> Array:
        return np.asarray(self.inertia / self.bench.passive.inertia(self._own(x)))

    def _own(self, x: Array) -> Array:
        return x[: len(self.bench.kernel.parameters)]


@dataclass(frozen=True, slots=True, eq=False)
class _Weighted:
    """A problem with its weights, and with a pull of each number towards where it is thought to be."""

    problem: Problem
    x: Array  # everything, also what is not fitted
    where: Sequence[int]
    weight: Array
    thought: Array
    pull: Array  # one over the standard deviation that it is thought to have; 0: nothing is thought of it

    def at(self, part: Array) -> Array:
        moved = self.x.copy()
        moved[self.where] = part
        return moved

    def residual(self, part: Array) -> Array:
        seen = (self.problem.residual(self.at(part)) * self.weight).ravel()
        return np.concatenate([seen, self.pull * (self.thought - part)])

    def columns(self, part: Array) -> Array:
        seen = (self.problem.columns(self.at(part)) * self.weight[:, None]).reshape(-1, len(part))
        return np.concatenate([seen, np.diag(self.pull)])

    def slope(self, part: Array) -> Array:
        return -self.columns(part)

    def loss(self, part: Array) -> float:
        return float(np.sum(self.residual(part) ** 2))


def _minimise(problem: _Weighted, limits: tuple[Array, Array], size: Array, steps: int | None) -> tuple[Array, bool]:
    part, ended = problem.x[problem.where], True
    previous = problem.loss(part)
    for _ in range(MAX_ITERATIONS if steps is None else steps):
        columns, target = problem.columns(part)[:, None], problem.residual(part)[:, None]
        step = solve_bounded(columns, target, size, limits[0] - part, limits[1] - part)
        part, loss = _line_search(problem, part, step, previous)
        fall, previous = previous - loss, loss
        if fall <= SETTLED * previous:
            break
    else:
        ended = steps is not None
        if not ended and fall > CREEPING * previous:
            part = _trust_region(problem, part, size, limits)
    return problem.at(part), ended


def _trust_region(problem: _Weighted, part: Array, size: Array, limits: tuple[Array, Array]) -> Array:
    """What Gauss-Newton does not settle: parameters that appear as products, in a model that lacks something."""
    start = np.clip(part, *limits)
    solution = optimize.least_squares(
        problem.residual,
        start,
        jac=problem.slope,
        bounds=limits,
        x_scale=size,
        ftol=SETTLED,
        max_nfev=EVALUATIONS,
    )
    if not solution.success and 2.0 * solution.cost > problem.loss(start):
        message = f"the fit of {len(part)} parameters did not settle: {solution.message}"
        raise NumericalError(errors.Problem("SD612", message))
    return np.asarray(solution.x)


def _line_search(problem: _Weighted, part: Array, step: Array, previous: float) -> tuple[Array, float]:
    """The longest of the step's halvings that does not raise the loss; none at all when none does."""
    scale = 1.0
    while scale > 1e-4:
        trial = part + scale * step
        loss = problem.loss(trial)
        if loss <= previous:
            return trial, loss
        scale /= 2.0
    return part, previous


def joint_weight(residual: Array, effort: Array) -> Array:
    """(n,) one over the residual's size per joint, so that joints of all sizes count alike; none where nothing acts."""
    size = np.sqrt(np.mean(residual**2, axis=0))
    size = np.maximum(size, 1e-6 * np.sqrt(np.mean(effort**2, axis=0)))
    return np.asarray(np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0))


def relative_error(residual: Array, effort: Array) -> float:
    """Size of the residual over that of the measured effort; joints that have any count alike (root mean square)."""
    power = np.sum(effort**2, axis=0)
    has = power > 0
    return float(np.sqrt(np.mean(np.sum(residual[:, has] ** 2, axis=0) / power[has]))) if has.any() else 0.0
