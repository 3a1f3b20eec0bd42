"""Parameters that absorbed what the model lacks, and where fits start then: one of an input that comes late, too."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.beliefs import Beliefs
from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.likelihood import MLFit, fit

Array = NDArray[np.float64]

FAR = 2.0  # standard deviations of its prior that a parameter may go before it is suspect
LONGEST = 0.02  # s: the latest input that is looked for, or so many half steps
MOST = 10  # delays that are tried, no closer than half a step
FEW = 3  # rounds of a fit from each of the likeliest
LIKELIEST = 3


class Fitted(Protocol):
    """An explanation, as far as it is needed here."""

    @property
    def beliefs(self) -> Beliefs: ...
    @property
    def fit(self) -> MLFit: ...


def absorbing(current: Fitted) -> tuple[str, ...]:
    """Parameters that went where no data sheet is wrong: they may be absorbing what the model lacks."""
    p, index = current.fit.p, current.fit.bench.index
    return tuple(
        name for name, b in current.beliefs.items()
        if np.isfinite(b.spread) and abs(b.coordinate(p[index[name]]) - b.centre) > FAR * b.spread
    )  # fmt: skip


def put_back(current: Fitted, p: Array) -> Array:
    """The parameters with what is suspect at its given value."""
    given = p.copy()
    for name in absorbing(current):
        given[current.fit.bench.index[name]] = current.beliefs[name].value(current.beliefs[name].centre)
    return given


def late(current: Fitted, p: Array, name: str) -> Array:
    """The parameters with that delay where a fit of them should start: what is suspect back at its given value."""
    bench, beliefs = current.fit.bench, current.beliefs
    given = put_back(current, p)
    step = float(np.nanmedian(bench.signals.steps))
    tried = []
    for delay in np.linspace(0.0, max(LONGEST, 0.5 * MOST * step), MOST + 1)[1:]:
        trial = given.copy()
        trial[bench.index[name]] = delay
        tried.append((bench.filtered(trial).loss, float(delay), trial))
    tried.sort(key=lambda item: item[:2])
    fits = [fit(bench, start, beliefs, most=FEW) for start in (p, *(t[2] for t in tried[:LIKELIEST]))]
    return min(fits, key=lambda f: f.loss).p


def the_other_way(bench: FilterBench, p: Array, before: Between) -> Array:
    """The parameters for a bench whose inputs were ``before`` something else between samples.

    What is held is half a step late by itself: delays that were found are moved by that.
    """
    moved, held = p.copy(), bench.between is Between.HELD
    by = 0.5 * float(np.nanmedian(bench.signals.steps)) if held is not (before is Between.HELD) else 0.0
    for i in (bench.index[name] for name in bench.delays):
        if p[i] > 0.0:
            moved[i] = max(p[i] - by if held else p[i] + by, 0.0)
    return moved
