"""Intervals where the likelihood falls less than its curvature says: they reach as far as it does not tell."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.beliefs import coordinates, penalty, per_coordinate
from symdyn.numeric.filtering.likelihood import MLFit

Array = NDArray[np.float64]

WAY = 2.0  # standard errors either way: there -log L has risen by
RISE = 0.5 * WAY**2  # nats, if it is a parabola
TURNS = 4  # of looking farther, each of them
FARTHER = 2.0  # times as far at most


def with_reach(fit: MLFit, names: Collection[str]) -> MLFit:
    """The same fit, its standard errors of those ``names`` no smaller than half the way to where -log L rises by two.

    Each is looked for along the line on which the other parameters follow (of a parabola: its profile), on both sides,
    with noise as it was fitted; the longer side counts. Never smaller than they were: where innovations are not white,
    the robust ones are larger than the likelihood's.
    """
    bench, covariance = fit.bench, fit.covariance
    names = [name for name in names if name in fit.beliefs]
    if not names or not np.all(np.isfinite(covariance)):
        return fit
    known, where = tuple(fit.beliefs.values()), [bench.index[name] for name in fit.beliefs]
    here = coordinates(fit.p, bench.index, fit.beliefs)
    factor = per_coordinate(fit.p[where], known)

    def rise(way: Array) -> float:
        p = fit.p.copy()
        p[where] = [b.value(x) for b, x in zip(known, here + way, strict=True)]
        return bench.filtered(p).loss + penalty(p, bench.index, fit.beliefs) - fit.loss

    reach = np.ones(len(known))
    for name in names:
        i = fit.names.index(name)
        if covariance[i, i] > 0.0:
            one = covariance[i] / (factor * np.sqrt(covariance[i, i]))
            reach[i] = max(_until(rise, side * one) for side in (-WAY, WAY))
    return replace(fit, reach=reach)


def _until(rise: Callable[[Array], float], way: Array) -> float:
    """How many times this way -log L takes to rise by ``RISE``; 1 where it takes less."""
    times = 1.0
    for _ in range(TURNS):
        risen = rise(times * way)
        if not risen < RISE:
            break
        times *= min(float(np.sqrt(RISE / max(risen, 1e-300))), FARTHER)
    return times
