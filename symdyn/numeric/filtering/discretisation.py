"""What the steps of a filter do to a fit: its values differ from those of finer steps, and its intervals say so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symdyn.numeric.filtering.likelihood import MLFit, fit

FINER = 4  # steps in place of one
REST = FINER / (FINER - 1.0)  # error over what finer steps change, where it goes with the step (across a kink it does)


def with_discretisation(coarse: MLFit) -> MLFit:
    """The same fit, which knows how far its values would go if the steps had no length (after Richardson, 1911)."""
    finer = fit(coarse.bench.in_steps(FINER), coarse.p, coarse.beliefs)
    change = (finer.p - coarse.p)[[coarse.bench.index[name] for name in coarse.names]]
    return replace(coarse, discretisation=REST * change) if np.all(np.isfinite(change)) else coarse
