"""What the steps of a filter do to a fit: its values differ from those of finer steps, and its intervals say so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symdyn.numeric.filtering.beliefs import penalty
from symdyn.numeric.filtering.likelihood import MLFit
from symdyn.numeric.filtering.parameter_step import At, parameter_step

FINER = 4  # steps in place of one
STEPS = 2  # of a fit
REST = FINER / (FINER - 1.0)  # error over what finer steps change, where it goes with the step (across a kink it does)


def with_discretisation(coarse: MLFit) -> MLFit:
    """The same fit, which knows how far its values would go if the steps had no length (after Richardson, 1911).

    They go a little: two steps of a fit, beside noise as it is, are as good as all.
    """
    if not coarse.names:
        return coarse
    finer, index, beliefs = coarse.bench.in_steps(FINER), coarse.bench.index, coarse.beliefs
    at = At(coarse.p, finer.filtered(coarse.p).loss + penalty(coarse.p, index, beliefs))
    for _ in range(STEPS):
        at = parameter_step(finer, at, beliefs)
    change = (at.p - coarse.p)[[index[name] for name in coarse.names]]
    return replace(coarse, discretisation=REST * change, finer=finer) if np.all(np.isfinite(change)) else coarse
