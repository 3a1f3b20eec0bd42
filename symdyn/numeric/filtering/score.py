"""Which hypothesis could explain what is left: score tests on the innovations, in a few runs of the filter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.decomposition import least_squares, svd
from symdyn.numeric.filtering.bench import FilterBench, Pass
from symdyn.numeric.filtering.hypotheses import shape_values
from symdyn.numeric.filtering.side_by_side import side_by_side

Array = NDArray[np.float64]

RANK = 1e-6  # of the largest singular value of columns of unit length


@dataclass(frozen=True, slots=True, eq=False)
class Score:
    """A hypothesis at its best shape: expected ``gain`` in nats, first ``estimate`` of its linear parameters."""

    candidate: Candidate
    shape: float | None
    gain: float
    estimate: Array
    tests: int

    @property
    def p_value(self) -> float:
        """Of such a gain by chance, all shapes that were tried allowed for."""
        return min(1.0, self.tests * float(stats.chi2.sf(2.0 * self.gain, max(self.candidate.size, 1))))


def scores(
    bench: FilterBench,
    p: Array,
    own: Sequence[str],
    proposed: Sequence[Candidate],
    progress: Callable[[str], None] = lambda _: None,
) -> list[Score]:
    """Every hypothesis, best first; the parameters ``own`` that are fitted anyway count as explained already.

    Rao's test: half the fall of the sum of squared innovations when the effect's columns are added,
    linearised at its null value, for every value of its shape parameter. None at all where the filter loses its way.
    """
    n = len(bench.kernel.coordinates)
    base = bench.filtered(p)
    if not np.isfinite(base.loss):
        return []
    speeds = dict(
        zip(bench.kernel.coordinates, np.quantile(np.abs(base.states[:, n : 2 * n]), 0.99, axis=0), strict=True)
    )
    fastest = max(speeds.values())
    runs: list[list[tuple[Candidate, float]]] = []  # with the first shape of each hypothesis, with the second, ...
    tests: dict[str, int] = {}
    for candidate in proposed:
        speed = float(speeds.get(candidate.place.address, fastest))
        values = shape_values(candidate, bench.kernel, bench.signals, speed)
        tests[candidate.label] = len(values)
        runs += [[] for _ in range(len(values) - len(runs))]
        for members, value in zip(runs, values, strict=False):
            members.append((candidate, float(value)))
    best: dict[str, Score] = {}
    left = Left.of(bench, p, own)
    progress(f"{len(proposed)} hypotheses in {sum(tests.values())} shapes")
    for score in chain.from_iterable(side_by_side(lambda members: _at(bench, p, members, tests, left), runs)):
        label = score.candidate.label
        if label not in best or score.gain > best[label].gain:
            best[label] = score
    return sorted(best.values(), key=lambda s: (-s.gain, s.candidate.label))


@dataclass(frozen=True, slots=True, eq=False)
class Left:
    """What a fitted model leaves of its whitened innovations (N m,), and what its own parameters would take off."""

    residual: Array
    basis: Array  # (N m, k) orthonormal

    @classmethod
    def of(cls, bench: FilterBench, p: Array, own: Sequence[str]) -> Left:
        done = bench.filtered(p, tuple(own))
        basis = _basis(whitened(done).reshape(done.white.size, len(own)))
        residual = done.white.ravel()
        return cls(residual - basis @ (basis.T @ residual), basis)

    @property
    def power(self) -> float:
        return float(self.residual @ self.residual)

    def without(self, residual: Array) -> Array:
        return np.asarray(residual - self.basis @ (self.basis.T @ residual))

    def explained(self, columns: Array, lower: Array, upper: Array) -> tuple[float, Array, Array]:
        """Gain in nats by such columns (N m, k), the best multiples of them within bounds, and what is left then."""
        length = np.linalg.norm(columns, axis=0)
        length = np.where(length > 0, length, 1.0)
        free = self.without(columns / length)
        visible = np.linalg.norm(free, axis=0) > RANK
        estimate = np.zeros(columns.shape[1])
        if visible.any():
            estimate[visible] = least_squares(free[:, visible], self.residual, rcond=RANK)
        inside = np.clip(estimate / length, lower, upper)  # friction that drives is no friction
        rest = self.residual - free @ (inside * length)
        return 0.5 * (self.power - float(rest @ rest)), inside, rest


def whitened(done: Pass) -> Array:
    """(N, m, k) what a parameter takes off the whitened innovations, per unit."""
    return np.asarray(-done.slopes / np.sqrt(done.variances)[:, :, None])


def _at(
    bench: FilterBench, p: Array, members: Sequence[tuple[Candidate, float]], tests: dict[str, int], left: Left
) -> list[Score]:
    """Hypotheses that are linear, each at one value of its shape, in one run; those of shape alone, one by one.

    At their null values none of them moves the machine: a run serves them all, whatever their shapes are.
    """
    found = []
    linear = [(c, value) for c, value in members if c.linear]
    if linear:
        moved = p.copy()
        for c, value in linear:
            moved[[bench.index[c.parameter(schema)] for schema in c.shapes]] = value
        names = tuple(c.parameter(s) for c, _ in linear for s in c.linear)
        columns = whitened(bench.filtered(moved, names)).reshape(-1, len(names))
        first = 0
        for c, value in linear:
            own = columns[:, first : first + len(c.linear)]
            first += len(c.linear)
            gain, estimate, _ = left.explained(own, *_limits(c))
            found.append(Score(c, value if c.shapes else None, gain, estimate, tests[c.label]))
    for c, value in members:
        if not c.linear and c.shapes:
            moved = p.copy()
            moved[[bench.index[c.parameter(schema)] for schema in c.shapes]] = value
            rest = left.without(bench.filtered(moved).white.ravel())
            gain = 0.5 * (left.power - float(rest @ rest))
            found.append(Score(c, value, gain, np.zeros(0), tests[c.label]))
    return found


def _limits(candidate: Candidate) -> tuple[Array, Array]:
    lower = np.array([-np.inf if s.lower is None else s.lower for s in candidate.linear])
    return lower, np.array([np.inf if s.upper is None else s.upper for s in candidate.linear])


def _basis(columns: Array) -> Array:
    length = np.linalg.norm(columns, axis=0)
    u, size, _ = svd(columns / np.where(length > 0, length, 1.0), full_matrices=False)
    return np.asarray(u[:, size > RANK * size.max(initial=0.0)])
