"""Forward selection of missing effects: chosen on training data by cross-validation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.regression import RANK_TOLERANCE, encompassing, solve_linear
from symdyn.numeric.scan import grid
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

FOLDS = 8  # contiguous blocks, so that a block's neighbours do not give it away
TIE = 0.05  # explanations that the best one improves on with a larger p-value are rivals
SAME = 1e-3  # part of a law that another one must leave for the two to differ; noise hides less


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """One candidate, tried: its best shape value and its cross-validated errors."""

    candidate: Candidate
    shape: float | None
    tests: int  # how many shape values were tried
    estimate: Array  # of its linear parameters, all training data
    errors: Array  # (K, n), weighted
    gain: float  # mean loss before less mean loss after
    p_value: float  # of "no gain", one-sided

    @property
    def loss(self) -> float:
        return float(np.mean(self.errors**2))

    @property
    def admissible(self) -> bool:
        """Within the bounds of its parameters: friction that drives is no friction."""
        return all(
            (s.lower is None or value >= s.lower) and (s.upper is None or value <= s.upper)
            for s, value in zip(self.candidate.linear, self.estimate, strict=True)
        )


class Search:
    """Tries candidates on top of a current explanation, linearised at its parameters."""

    def __init__(self, bench: Workbench, p: Array, names: Sequence[str], weight: Array, joints: Sequence[str]) -> None:
        self.bench, self.p, self.weight = bench, p, weight
        self.joints = tuple(joints)
        self.target = bench.residual(p) * weight
        self.base = bench.columns(p, names) * weight[:, None] if names else np.zeros((*self.target.shape, 0))
        flat = self.base.reshape(-1, self.base.shape[2])
        u, size, _ = np.linalg.svd(flat / (np.linalg.norm(flat, axis=0) + 1e-300), full_matrices=False)
        self._basis = u[:, size > RANK_TOLERANCE * size.max(initial=0.0)]
        left = self.target.reshape(-1)
        self._left = left - self._basis @ (self._basis.T @ left)
        self.errors = self._cross_validated(self.base)

    def trial(self, candidate: Candidate) -> Trial:
        """The candidate at the best value of its shape parameter."""
        joint = self.joints.index(candidate.place.address)
        band = self.bench.band
        cutoff = band.cutoff if band else 0.4 * self.bench.observation.rate
        values = grid(candidate, joint, self.bench.observation, cutoff)
        shape, tests = None, len(values)
        if candidate.shape is not None:
            shape = self._best_shape(candidate, values)
        design = np.concatenate([self.base, self._columns(candidate, shape)], axis=2)
        estimate = solve_linear(design, self.target)[self.base.shape[2] :]
        errors = self._cross_validated(design)
        gain, p_value = encompassing(self.errors, errors)
        return Trial(candidate, shape, tests, estimate, errors, gain, p_value)

    def contains(self, larger: Trial, smaller: Trial) -> bool:
        """Whether one candidate's law is the other's with more freedom, on this recording."""
        if larger.candidate.size <= smaller.candidate.size:
            return False
        wide, narrow = (self._columns(t.candidate, t.shape).reshape(len(self._left), -1) for t in (larger, smaller))
        space = np.concatenate([self._basis, wide], axis=1)
        left = narrow - space @ np.linalg.lstsq(space, narrow, rcond=RANK_TOLERANCE)[0]
        return bool(np.all(np.linalg.norm(left, axis=0) <= SAME * np.linalg.norm(narrow, axis=0)))

    def _best_shape(self, candidate: Candidate, values: Array) -> float:
        losses = np.array([self._training_loss(candidate, value) for value in values])
        best = int(np.argmin(losses))
        low, high = values[max(best - 1, 0)], values[min(best + 1, len(values) - 1)]
        if high <= low:
            return float(values[best])
        found = optimize.minimize_scalar(
            lambda value: self._training_loss(candidate, value), bounds=(low, high), method="bounded",
            options={"xatol": 1e-3 * float(high - low)},
        )  # fmt: skip
        return float(found.x) if found.fun < losses[best] else float(values[best])

    def _training_loss(self, candidate: Candidate, shape: float) -> float:
        """Loss on all training data; the current explanation has been projected out beforehand."""
        columns = self._columns(candidate, shape).reshape(len(self._left), -1)
        columns = columns - self._basis @ (self._basis.T @ columns)
        solution, *_ = np.linalg.lstsq(columns, self._left, rcond=1e-9)
        return float(np.sum((self._left - columns @ solution) ** 2))

    def _columns(self, candidate: Candidate, shape: float | None) -> Array:
        named = None if candidate.shape is None or shape is None else (candidate.parameter(candidate.shape), shape)
        names = [candidate.parameter(schema) for schema in candidate.linear]
        return self.bench.effect_columns(names, named) * self.weight[:, None]

    def _cross_validated(self, design: Array) -> Array:
        """(K, n) errors of each sample under the fit to the other blocks."""
        errors = np.empty_like(self.target)
        for block in np.array_split(np.arange(len(self.target)), FOLDS):
            rest = np.setdiff1d(np.arange(len(self.target)), block)
            estimate = solve_linear(design[rest], self.target[rest])
            errors[block] = self.target[block] - design[block] @ estimate
        return errors


def rank(
    search: Search, proposed: Sequence[Candidate], level: float, progress: Callable[[str], None]
) -> tuple[list[Trial], list[Trial]]:
    """Trials that earn their place at significance ``level`` (Bonferroni over all that was tried).

    Returns (earning, best first; inadmissible ones that would have earned it). Explanations that
    cannot be told from the best (``TIE``) are ordered by how few numbers they bring.
    """
    trials = []
    for candidate in proposed:
        progress(candidate.label)
        trials.append(search.trial(candidate))
    tests = sum(trial.tests for trial in trials)
    earning = [t for t in trials if t.gain > 0 and t.p_value * tests < level]
    refused = [t for t in earning if not t.admissible]
    earning = sorted((t for t in earning if t.admissible), key=lambda t: t.loss)
    if earning:
        best = earning[0]
        # What the best one has beyond another that it contains must earn its place like any finding.
        tied = [
            t
            for t in earning
            if t is best or encompassing(t.errors, best.errors)[1] > (level if search.contains(best, t) else TIE)
        ]
        tied.sort(key=lambda t: (t.candidate.size, t.loss))
        earning = tied + [t for t in earning if t not in tied]
    return earning, refused
