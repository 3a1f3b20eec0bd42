"""Noise of positions bends what is fitted: by how much, a little more of it tells, and intervals say so."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import NumericalError
from symdyn.numeric.explanation import Case, Explanation
from symdyn.numeric.inquiry import Inquiry

Array = NDArray[np.float64]


def with_trembling(inquiry: Inquiry, progress: Callable[[str], None]) -> Inquiry:
    """The same, its covariance with the square of what noise of positions has done to every number.

    Accelerations carry it, and least squares takes a regressor that trembles for a smaller one. As much noise again
    bends every number as far again (simulation and extrapolation: Cook and Stefanski 1994), and half the sum of what
    that noise and its negative do holds nothing of chance in first order. What is told without it may be bent by so
    much, in one direction: no more samples help.
    """
    now = inquiry.current
    if not now.found:
        return inquiry
    progress("how far the noise of positions bends the numbers")
    seen = inquiry.setting.seen
    sizes = np.sqrt(seen.noise * seen.rate / 2.0)  # of white noise: its density up to half the rate
    samples = len(inquiry.setting.training.time)  # of an observation there may be other ones, at even steps
    noise = sizes * np.random.default_rng(0).standard_normal((samples, len(sizes)))
    try:
        bent = [_values(*_explained(inquiry, way * noise)) for way in (1.0, -1.0)]
    except NumericalError:
        return inquiry
    last = now.fit.last
    change = 0.5 * (bent[0] + bent[1]) - _values(inquiry.case, now)
    wider = replace(last, covariance=last.covariance + np.outer(change, change))
    return replace(inquiry, current=replace(now, fit=replace(now.fit, last=wider))).settled()


def _explained(inquiry: Inquiry, noise: Array) -> tuple[Case, Explanation]:
    """What was found, fitted to the recording with this noise (N, n) on its positions."""
    case = inquiry.setting.trembling(noise).case(*inquiry.band)
    case = replace(case, spread=inquiry.case.spread)
    return case, case.explain(inquiry.current.found, inquiry.current)


def _values(case: Case, of: Explanation) -> Array:
    """(k,) in the order of the fit's names."""
    own = of.fit.p[[case.bench.index[name] for name in case.own]]
    return np.concatenate([own, *(np.array([*f.coefficients, *f.shapes]) for f in of.fitted)])
