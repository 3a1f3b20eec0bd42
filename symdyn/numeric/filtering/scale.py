"""How large all forces and masses are together: nothing tells it where none of them is known or was measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.beliefs import Beliefs, penalty, precision, pull
from symdyn.numeric.filtering.bench import FilterBench

Array = NDArray[np.float64]

WORTH = 0.1  # nats of the prior: less is not worth a run of the filter


def as_believed(bench: FilterBench, p: Array, loss: float, beliefs: Beliefs) -> tuple[FilterBench, Array, float]:
    """All forces and masses larger by one factor, the one that is believed most; or all as it was.

    The motion stays the same by that. A fit that goes from slope to slope has no sure way there: to the likelihood it
    is flat, and beside it steep.
    """
    heavy = np.array([of_force(unit) for unit in bench.kernel.parameter_units], dtype=bool)
    forces = [int(i) for i in np.flatnonzero(heavy & (p[: len(heavy)] != 0.0))]
    free = {bench.index[name] for name in beliefs}
    if not free.issuperset(forces):
        return bench, p, loss
    at = [(bench.index[name], belief) for name, belief in beliefs.items()]
    change = np.array([(1.0 if belief.positive else p[i]) if i in forces else 0.0 for i, belief in at])
    slope = float(change @ pull(p, bench.index, beliefs))
    curvature = float(change @ precision(beliefs) @ change)
    if not slope**2 > 2.0 * WORTH * curvature:
        return bench, p, loss
    factor = float(np.exp(slope / curvature))
    trial = p.copy()
    trial[forces] *= factor
    pushed = ~np.any(bench.noise.directions[~heavy], axis=0)  # unknown forces grow along
    larger = np.where(pushed, factor**2, 1.0)
    noise = replace(bench.noise, power=larger * bench.noise.power, most=larger * bench.noise.most)
    scaled = bench.with_noise(noise)
    found = scaled.filtered(trial).loss + penalty(trial, bench.index, beliefs)
    return (scaled, trial, found) if found < loss else (bench, p, loss)


def of_force(unit: str) -> bool:
    """Whether what has this unit is in proportion to force, as masses are."""
    return unit.partition(" ")[0].partition("/")[0] in ("N", "kg")
