"""Profile likelihood of a parameter: how the effort misfit grows as it is moved and all others are fitted anew."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, stats

from symdyn.base.errors import NumericalError
from symdyn.numeric.decomposition import least_squares
from symdyn.numeric.fitting import fit
from symdyn.numeric.identify import Fitted
from symdyn.numeric.regression import fit_linear

Array = NDArray[np.float64]

CONFIDENCE = 0.95
SPAN = 100.0  # a side that is still open this many times the value away (or that many standard errors) is open
POINTS = 8  # of the curve, on each side
BEYOND = 1.3  # times the distance of an end: how far the curve is drawn
ACCURACY = 2e-3  # of an end of the interval, of its distance from the estimate
FIRST = 0.01  # of the value: the first step where no standard error tells one


class Identified(StrEnum):
    """What the recording tells of a parameter by itself (Raue et al. 2009)."""

    YES = "identified"
    PRACTICALLY_NOT = "practically_not"  # the misfit grows, but not beyond chance on at least one side
    NOT = "not"  # it does not grow at all: other parameters take its part


@dataclass(frozen=True, slots=True)
class Profile:
    """``values`` and ``rise`` of the curve: the fall of 2 log L, correlated residuals allowed for.

    ``lower`` and ``upper`` are the ends of the interval, None where it is open within the bounds that were searched.
    """

    parameter: str
    unit: str
    estimate: float
    lower: float | None
    upper: float | None
    threshold: float
    identified: Identified
    values: tuple[float, ...]
    rise: tuple[float, ...]

    def to_json(self) -> dict[str, Any]:
        return {
            "parameter": self.parameter,
            "unit": self.unit,
            "estimate": self.estimate,
            "interval": [self.lower, self.upper],
            "confidence": CONFIDENCE,
            "threshold": self.threshold,
            "identified": str(self.identified),
            "curve": {"values": list(self.values), "rise": list(self.rise)},
        }


def profile(fitted: Fitted, name: str, bounds: Mapping[str, tuple[float, float]]) -> Profile:
    """The profile of one fitted parameter on either side of its estimate, within its bounds.

    The interval ends where twice the log-likelihood has fallen by the chi-squared quantile of one degree of
    freedom. Residuals are correlated: the fall of a likelihood that takes them for white is divided by the ratio
    of the variance that they really cause to the one that white ones would (Chandler and Bate 2007).
    """
    walk = _Walk(fitted, name, bounds)
    threshold = float(stats.chi2.ppf(CONFIDENCE, 1))
    low, high = bounds.get(name, (-math.inf, math.inf))
    sides = [_side(walk, sign, threshold, limit) for sign, limit in ((-1.0, low), (1.0, high))]
    estimate = walk.estimate
    curve = sorted({**dict(sides[0][1]), estimate: 0.0, **dict(sides[1][1])}.items())
    ends = [end for end, _ in sides]
    grown = max(rise for _, rise in curve)
    flat = grown < ACCURACY * threshold
    identified = Identified.NOT if flat else Identified.YES if None not in ends else Identified.PRACTICALLY_NOT
    unit = fitted.bench.kernel.parameter_units[fitted.bench.index[name]]
    values, rise = zip(*curve, strict=True)
    return Profile(name, unit, estimate, ends[0], ends[1], threshold, identified, tuple(values), tuple(rise))


class _Walk:
    """Refits with one parameter held; each starts from the nearest one that lies between it and the estimate."""

    def __init__(self, fitted: Fitted, name: str, bounds: Mapping[str, tuple[float, float]]) -> None:
        self.fitted, self.name, self.bounds = fitted, name, bounds
        self.bench, self.weight = fitted.bench, fitted.weight
        self.at = self.bench.index[name]
        self.others = [other for other in fitted.fit.names if other != name]
        self.estimate = float(fitted.fit.p[self.at])
        self.done: dict[float, Array] = {self.estimate: fitted.fit.p}
        self.least = self._loss(fitted.fit.p)
        self.scale = self._white_variance() * self._inflation()

    def rise(self, value: float) -> float:
        """Fall of 2 log L from the best fit to the best with the parameter at this value."""
        if value not in self.done:
            between = [v for v in self.done if min(v, value) >= self.estimate or max(v, value) <= self.estimate]
            inner = [v for v in between if abs(v - self.estimate) <= abs(value - self.estimate)]
            p = self.done[min(inner, key=lambda v: abs(v - value))].copy()
            p[self.at] = value
            with suppress(NumericalError):  # it creeps along a valley: what it started from is a bound of it
                p = fit(self.bench, p, self.others, self.weight, self.bounds).p
            self.done[value] = p
        return max(self._loss(self.done[value]) - self.least, 0.0) / self.scale

    def standard_error(self) -> float:
        """From the fit; nan where that does not tell."""
        error = self.fitted.fit.standard_error(self.name)
        return math.nan if error is None else error

    def _loss(self, p: Array) -> float:
        return float(np.sum((self.bench.residual(p) * self.weight) ** 2))

    def _white_variance(self) -> float:
        return self.least / max(int(self.bench.effort.size) - len(self.fitted.fit.names), 1)

    def _inflation(self) -> float:
        """Variance of the estimate over that of one from white residuals of the same size.

        It is taken in the direction in which the profile runs: the part of the parameter's column that the others
        do not explain. Where that is nothing, there is nothing to scale.
        """
        p = self.fitted.fit.p
        columns = self.bench.columns(p, [self.name, *self.others]) * self.weight[:, None]
        own, rest = columns[:, :, :1], columns[:, :, 1:].reshape(columns.shape[0] * columns.shape[1], -1)
        flat = own.reshape(-1)
        left = flat - rest @ least_squares(rest, flat, rcond=1e-9) if self.others else flat
        if not np.any(left):
            return 1.0
        found = fit_linear(left.reshape(own.shape), self.bench.residual(p) * self.weight)
        count = len(own)
        others = max(count - 1, 1) / max(count - len(self.fitted.fit.names), 1)  # the others were fitted, too
        white = self._white_variance() / float(left @ left)
        return max(float(found.covariance[0, 0]) * others / white, 1e-12)


def _side(walk: _Walk, sign: float, threshold: float, limit: float) -> tuple[float | None, list[tuple[float, float]]]:
    """(end of the interval or None, points of the curve) on one side."""
    size, error = abs(walk.estimate), walk.standard_error()
    step = error if math.isfinite(error) and error > 0 else FIRST * (size or 1.0)
    farthest = SPAN * max(size, step)
    room = min(abs(limit - walk.estimate), farthest)
    if room <= 0:
        return None, []
    inside, outside = 0.0, min(step, room)
    while (risen := walk.rise(walk.estimate + sign * outside)) < threshold and outside < room:
        inside, outside = outside, min(2.0 * outside, room)
    end = None
    if risen >= threshold:

        def above(distance: float) -> float:
            # A parabola's root; behind a wall (another parameter at its bound) heights mean nothing.
            return math.sqrt(min(walk.rise(walk.estimate + sign * distance), 4.0 * threshold)) - math.sqrt(threshold)

        distance = float(optimize.brentq(above, inside, outside, xtol=ACCURACY * outside))
        end, outside = walk.estimate + sign * distance, BEYOND * distance
    values = [walk.estimate + sign * d for d in np.linspace(0.0, min(outside, room), POINTS + 1)[1:]]
    return end, [(float(value), walk.rise(float(value))) for value in values]
