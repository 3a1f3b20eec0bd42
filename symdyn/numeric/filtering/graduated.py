"""Parameters that are far off, brought near: fitted with forces of which nothing is known, less of them each time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.beliefs import Beliefs, penalty
from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.model import Model, natural_force
from symdyn.numeric.filtering.parameter_step import At, parameter_step
from symdyn.numeric.filtering.windows import white_noise

Array = NDArray[np.float64]

POWERS = np.logspace(-3, -13, 6)  # of the forces, relative to what moves the machine
STEPS = 3  # of the parameters at each, at most
SETTLED = 1.0  # nats


def graduated(model: Model, bench: FilterBench, p: Array, beliefs: Beliefs) -> tuple[FilterBench, Array]:
    """Where a fit may begin: a filter without unknown forces, its sensors as good as they may be, and (np,) parameters.

    A filter that lets every equation be off follows the recording with any parameters, sample by sample, and the slopes
    of its likelihood then lead a long way: to the masses of a pendulum behind a soft shaft, which a filter that
    believes in its equations does not find past the first few swings.
    """
    white = np.minimum(
        bench.noise.r, white_noise(bench.signals)
    )  # a guess a hundred times larger hides what leads there
    noise = replace(bench.noise.quiet, r=white)
    quiet = bench.with_noise(noise)
    if not beliefs:
        return quiet, p
    natural = np.array([natural_force(model, bench.signals, d) for d in noise.directions.T])
    for power in POWERS:
        loose = bench.with_noise(replace(noise, power=power * natural**2, most=np.full(len(natural), np.inf)))
        at = At(p, loose.filtered(p).loss + penalty(p, bench.index, beliefs))
        for _ in range(STEPS):
            before = at.loss
            at = parameter_step(loose, at, beliefs)
            if before - at.loss < SETTLED:
                break
        p = at.p
    return quiet, p
