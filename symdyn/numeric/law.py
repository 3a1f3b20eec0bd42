"""Which variable a named law is a law in, on a recording; whether what is left there refutes it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.explanation import Case, Explanation
from symdyn.numeric.findings import Remaining

Array = NDArray[np.float64]

BINS = 24
MOSTLY = 0.5  # of a law's power that a curve over a variable must hold for the law to be one in it


def refuted(case: Case, of: Explanation, remaining: Remaining) -> list[str]:
    """Labels of findings whose law does not hold: what is left follows their own variable at their own joint.

    Alone, or together with another variable of that joint. A structured rest that follows something else is
    another effect, and refutes nothing.
    """
    if not remaining.structured or remaining.variable is None:
        return []
    labels, variables = [], remaining.variable.split(" and ")
    for (candidate, _), fitted in zip(of.found, of.fitted, strict=True):
        joint, here = case.laws.joint(candidate), f" of {candidate.place.address}"
        force = case.laws.columns(candidate, fitted.shapes, of.fit.p) @ np.array(fitted.coefficients)
        if f"{_variable(case, joint, force)}{here}" in variables and all(v.endswith(here) for v in variables):
            labels.append(candidate.label)
    return labels


def _variable(case: Case, joint: int, force: Array) -> str | None:
    o, bench = case.bench.observation, case.bench
    power = float(np.sum((force - force.mean()) ** 2))
    best: tuple[float, str | None] = (MOSTLY, None)
    for name, values in (("position", o.q), ("speed", o.qd), ("acceleration", o.qdd)):
        cell = _cells(bench.bring(values)[:, joint])
        count = np.maximum(np.bincount(cell, minlength=BINS), 1)
        curve = np.bincount(cell, force, minlength=BINS) / count
        told = 1.0 - float(np.sum((force - curve[cell]) ** 2)) / max(power, 1e-300)
        best = max(best, (told, name), key=_first)
    return best[1]


def _cells(values: Array) -> NDArray[np.int_]:
    return np.digitize(values, np.quantile(values, np.linspace(0.0, 1.0, BINS + 1)[1:-1]))


def _first(pair: Sequence[object]) -> float:
    value = pair[0]
    assert isinstance(value, float)
    return value
