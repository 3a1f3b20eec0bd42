"""One step of Levenberg and Marquardt on the parameters of a filter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.beliefs import Belief, Beliefs, coordinates, penalty, per_coordinate, precision, pull
from symdyn.numeric.filtering.bench import TOO_LITTLE, FilterBench, Pass
from symdyn.numeric.filtering.bounded_step import bounded_step

Array = NDArray[np.float64]

FIRST_DAMPING, LEAST_DAMPED, MOST_DAMPED = 1e-3, 1e-9, 1e9  # of the curvature
AGAIN = 1.0  # damping after a step that led nowhere
LONGEST = 2.0  # step of a logarithm
RELATIVE = 0.7  # of a value, up to which a step is one of its logarithm
MODEST = 1e-6  # curvature that is added where there is none at all
HUGE = 1e150  # slopes of a filter that runs away: their squares are no numbers


@dataclass(frozen=True, slots=True, eq=False)
class At:
    """Where a fit stands: its parameters, -log L with the prior, damping for the next step."""

    p: Array
    loss: float
    damping: float = FIRST_DAMPING


def parameter_step(bench: FilterBench, at: At, beliefs: Beliefs) -> At:
    """The next place, within bounds; more damping where none is likelier.

    The slopes take the filter's gains as given. They lead across holes of the likelihood, at instants of sticking, that
    differences of the likelihood itself end in.
    """
    names, known = tuple(beliefs), tuple(beliefs.values())
    done = bench.filtered(at.p, names)
    raw = columns(done, at.p, [bench.index[name] for name in names], known)
    if not np.max(np.abs(raw), initial=0.0) < HUGE:  # on the way to infinity: nothing is known of a better direction
        return at
    return _lower(bench, at, beliefs, raw, raw.T @ done.white.ravel()) or At(at.p, at.loss, AGAIN)


def _lower(bench: FilterBench, at: At, beliefs: Beliefs, columns: Array, slope: Array) -> At | None:
    """A step that lowers the loss, if any does."""
    p, damping = at.p, at.damping
    where = [bench.index[name] for name in beliefs]
    known = tuple(beliefs.values())
    here = coordinates(p, bench.index, beliefs)
    positive = np.array([b.positive for b in known], dtype=bool)
    length = np.linalg.norm(columns, axis=0)
    scale = np.where(positive, 1.0, 1.0 / np.where(length > 0, length, 1.0))
    normal = (columns.T @ columns + precision(beliefs)) * np.outer(scale, scale)
    slope = (slope + pull(p, bench.index, beliefs)) * scale
    lower = np.array([-np.inf if b.positive else b.lower for b in known])
    upper = np.array([np.inf if b.positive else b.upper for b in known])
    growth = 10.0
    while damping < MOST_DAMPED:
        damped = normal + damping * np.diag(np.diag(normal) + MODEST)
        step = bounded_step(damped, slope, (lower - here) / scale, (upper - here) / scale)
        if step @ (slope - 0.5 * (normal @ step)) < TOO_LITTLE:  # with more damping it promises even less
            return None
        trial = p.copy()
        if np.max(np.abs(step[positive]), initial=0.0) < LONGEST:
            trial[where] = [_moved(b, x, by) for b, x, by in zip(known, here, scale * step, strict=True)]
            found = bench.filtered(trial).loss + penalty(trial, bench.index, beliefs)
            if found < at.loss:
                return At(trial, found, max(damping / 10.0, LEAST_DAMPED))
        damping *= growth
        growth *= 2.0
    return None


def _moved(known: Belief, coordinate: float, step: float) -> float:
    """The value a step away. What changes by a part of itself is multiplied, like what is positive.

    Where nothing tells a force's size (a motor whose torque constant is free), all forces and inertias may grow
    together: so that is a straight way.
    """
    if known.positive or not abs(step) < RELATIVE * abs(coordinate):
        return known.value(coordinate + step)
    return known.value(coordinate * float(np.exp(step / coordinate)))


def columns(done: Pass, p: Array, where: Sequence[int], known: Sequence[Belief]) -> Array:
    """(N m, k) what each coordinate takes off the whitened innovations."""
    factor = per_coordinate(p[list(where)], known)
    found: Array = -done.slopes / np.sqrt(done.variances)[:, :, None] * factor
    return found.reshape(-1, len(where))
