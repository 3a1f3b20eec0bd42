"""One step of Levenberg and Marquardt on the parameters of a filter; how far its slopes are off, where they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.beliefs import Belief, Beliefs, penalty
from symdyn.numeric.filtering.bench import FilterBench, Pass
from symdyn.numeric.filtering.side_by_side import side_by_side

Array = NDArray[np.float64]

FIRST_DAMPING, LEAST_DAMPED, MOST_DAMPED = 1e-3, 1e-9, 1e9  # of the curvature
LONGEST = 2.0  # step of a logarithm
DIFFERENCE = 0.1  # of a standard error, for difference quotients
MODEST = 1e-6  # curvature that is added where there is none at all


@dataclass(frozen=True, slots=True, eq=False)
class Off:
    """How far slopes of the filter are off: ``columns`` (N m, k) and ``slope`` (k,) of -log L to be added to them."""

    names: tuple[str, ...]
    columns: Array
    slope: Array

    def of(self, names: Sequence[str]) -> tuple[Array, Array]:
        """For these parameters; nothing is known of those that are new."""
        columns, slope = np.zeros((len(self.columns), len(names))), np.zeros(len(names))
        for j, name in enumerate(names):
            if name in self.names:
                i = self.names.index(name)
                columns[:, j], slope[j] = self.columns[:, i], self.slope[i]
        return columns, slope


@dataclass(frozen=True, slots=True, eq=False)
class At:
    """Where a fit stands: its parameters, -log L with the prior, damping for the next step."""

    p: Array
    loss: float
    damping: float = FIRST_DAMPING
    off: Off | None = None


def parameter_step(bench: FilterBench, at: At, beliefs: Beliefs, settled: float) -> At:
    """The next place, within bounds.

    Where friction jumps within a step of the filter, or a part of the machine is far quicker than that, the
    innovations' slopes may point elsewhere. Where they promise a gain and lead to none (less than ``settled`` nats),
    differences take their place; how far off they were is remembered for later steps.
    """
    p, names = at.p, tuple(beliefs)
    known = tuple(beliefs.values())
    done = bench.filtered(p, names)
    raw = columns(done, p, [bench.index[name] for name in names], known)
    if not np.all(np.isfinite(raw)):  # on the way to infinity: nothing is known of a better direction
        return at
    slope = raw.T @ done.white.ravel()
    more = at.off.of(names) if at.off else (0.0, 0.0)
    found, promised = _lower(bench, at, beliefs, raw + more[0], slope + more[1])
    if promised > settled and (found is None or at.loss - found.loss < settled):
        better = _by_differences(bench, p, beliefs, done, raw)
        off = Off(names, better[0] - raw, better[1] - slope)
        again, _ = _lower(bench, At(p, at.loss, FIRST_DAMPING, off), beliefs, *better)
        found = again or found or At(p, at.loss, 1.0, off)
    return found or At(p, at.loss, 1.0, at.off)


def _lower(bench: FilterBench, at: At, beliefs: Beliefs, columns: Array, slope: Array) -> tuple[At | None, float]:
    """A step that lowers the loss, if any does; and the gain that the slopes promise."""
    p, damping = at.p, at.damping
    where = [bench.index[name] for name in beliefs]
    known = tuple(beliefs.values())
    here = np.array([b.coordinate(p[i]) for i, b in zip(where, known, strict=True)])
    positive = np.array([b.positive for b in known], dtype=bool)
    length = np.linalg.norm(columns, axis=0)
    scale = np.where(positive, 1.0, 1.0 / np.where(length > 0, length, 1.0))
    precision = np.array([b.spread**-2 for b in known])
    wish = precision * (np.array([b.centre for b in known]) - here)
    normal = (columns.T @ columns + np.diag(precision)) * np.outer(scale, scale)
    slope = (slope + wish) * scale
    lower = np.array([-np.inf if b.positive else b.lower for b in known])
    upper = np.array([np.inf if b.positive else b.upper for b in known])
    growth, promised = 10.0, 0.0
    while damping < MOST_DAMPED:
        damped = normal + damping * np.diag(np.diag(normal) + MODEST)
        step = _within(damped, slope, (lower - here) / scale, (upper - here) / scale)
        promised = max(promised, float(slope @ step - 0.5 * step @ normal @ step))
        trial = p.copy()
        if np.max(np.abs(step[positive]), initial=0.0) < LONGEST:
            trial[where] = [b.value(x) for b, x in zip(known, here + scale * step, strict=True)]
            found = bench.filtered(trial).loss + penalty(trial, bench.index, beliefs)
            if found < at.loss:
                return At(trial, found, max(damping / 10.0, LEAST_DAMPED), at.off), promised
        damping *= growth
        growth *= 2.0
    return None, promised


def _by_differences(bench: FilterBench, p: Array, beliefs: Beliefs, done: Pass, columns: Array) -> tuple[Array, Array]:
    """What ``columns`` gives, and the slope of the likelihood: a run of the filter for each parameter."""
    length = np.linalg.norm(columns, axis=0)
    moved = DIFFERENCE * np.minimum(1.0, 1.0 / np.where(length > 0, length, 1.0))
    trials = []
    for j, (name, belief) in enumerate(beliefs.items()):
        i = bench.index[name]
        trial = p.copy()
        trial[i] = belief.value(belief.coordinate(p[i]) + moved[j])
        if trial[i] == p[i]:  # at its bound
            moved[j] = -moved[j]
            trial[i] = belief.value(belief.coordinate(p[i]) + moved[j])
        trials.append(trial)
    runs = side_by_side(bench.filtered, trials)
    sound = np.array([np.isfinite(there.loss) for there in runs])
    spread = np.sqrt(done.variances)
    found = np.stack([((done.innovations - there.innovations) / spread).ravel() for there in runs], axis=1) / moved
    found = np.where(sound, found, columns)
    gain = np.array([done.loss - there.loss if good else 0.0 for there, good in zip(runs, sound, strict=True)]) / moved
    return found, gain + 0.5 * moved * np.sum(found**2, axis=0)  # the quotient is that of the middle


def columns(done: Pass, p: Array, where: Sequence[int], known: Sequence[Belief]) -> Array:
    """(N m, k) what each coordinate takes off the whitened innovations."""
    factor = np.array([p[i] if b.positive else 1.0 for i, b in zip(where, known, strict=True)])
    found: Array = -done.slopes / np.sqrt(done.variances)[:, :, None] * factor
    return found.reshape(-1, len(where))


def _within(normal: Array, slope: Array, lower: Array, upper: Array) -> Array:
    """The solution of the normal equations, what runs into a bound held there (one way in, none out)."""
    step, free = np.zeros(len(slope)), np.ones(len(slope), dtype=bool)
    for _ in range(len(slope)):
        right = slope[free] - normal[np.ix_(free, ~free)] @ step[~free]
        step[free] = np.linalg.lstsq(normal[np.ix_(free, free)], right, rcond=1e-14)[0]
        out = free & ((step < lower) | (step > upper))
        if not out.any():
            break
        step = np.where(out, np.clip(step, lower, upper), step)
        free &= ~out
    return step
