"""What the steps of a filter do to a fit: its values differ from those of finer steps, and its intervals say so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.likelihood import MLFit
from symdyn.numeric.filtering.parameter_step import columns

Array = NDArray[np.float64]

FINER = 4  # steps in place of one
REST = FINER / (FINER - 1.0)  # error over what finer steps change, where it goes with the step (across a kink it does)


def stepped(fit: MLFit) -> MLFit:
    """The same fit, which knows how far its values would go if the steps had no length (after Richardson, 1911).

    To first order: what finer steps add to the slope of the likelihood, over its curvature there.
    """
    (slope, _, factor), (finer, normal, _) = (_slope(fit, bench) for bench in (fit.bench, fit.bench.in_steps(FINER)))
    if not (fit.beliefs and np.all(np.isfinite(slope)) and np.all(np.isfinite(finer)) and np.all(np.isfinite(normal))):
        return fit
    normal += np.diag([b.spread**-2 for b in fit.beliefs.values()])
    scale = 1.0 / np.sqrt(np.diag(normal))
    change = scale * np.linalg.lstsq(normal * np.outer(scale, scale), scale * (finer - slope), rcond=1e-14)[0]
    return replace(fit, stepping=REST * factor * change)


def _slope(fit: MLFit, bench: FilterBench) -> tuple[Array, Array, Array]:
    """(k,) of the likelihood, uphill, its curvature (k, k), what each coordinate moves its value by (k,)."""
    known, where = tuple(fit.beliefs.values()), [bench.index[name] for name in fit.names]
    done = bench.filtered(fit.p, fit.names)
    flat = columns(done, fit.p, where, known)
    factor = np.array([fit.p[i] if b.positive else 1.0 for i, b in zip(where, known, strict=True)])
    return flat.T @ done.white.ravel(), flat.T @ flat, factor
