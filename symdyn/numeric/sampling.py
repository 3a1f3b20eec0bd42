"""What the time between samples leaves of a residual though nothing is missing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.effects_fit import Fitted, Found
from symdyn.numeric.laws import Laws
from symdyn.numeric.observation import BESIDE, derivative, slope_gain
from symdyn.numeric.probe import key_of
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

WIDER = BESIDE + 1  # samples on either side, of the derivatives that judge those of an observation
WITHIN = (-0.375, -0.125, 0.125, 0.375)  # of a sample


def left_by_sampling(laws: Laws, found: Found, fitted: Sequence[Fitted], p: Array) -> Array:
    """(K, n) in the analysis band, as efforts are shown: by its size, not by its course.

    - Dry friction jumps where a speed reverses, and that is between two samples: what the forces of a sample are less
      their mean over the sample, the speed being straight in it.
    - Derivatives are those of polynomials: what wider ones make of the acceleration is their error.
    - An effort that is held over a sample T misses (omega T)^2 / 24 of what is recorded: its second derivative.
    """
    bench, o = laws.bench, laws.bench.observation
    between, held = np.zeros_like(o.tau), np.zeros_like(o.tau)
    for share, sign in [(at, 1.0 / len(WITHIN)) for at in WITHIN] + [(0.0, -1.0)]:
        moved = replace(o, qd=o.qd + share * o.sample_time * o.qdd)
        between += sign * bench.kernel.rows("inverse_dynamics_p", moved.q, moved.qd, moved.qdd, p)
        for (candidate, _), values in zip(found, fitted, strict=True):
            probe, joint = laws.probes[key_of(candidate)], laws.joint(candidate)
            if candidate.effect not in probe.memory:  # what remembers does not jump
                told = candidate.values(values.coefficients, values.shapes)
                between[:, joint] += sign * probe.force(candidate.effect, told, moved, joint)
    for part in o.segments:
        slope = derivative(o.tau[part], o.time[part])
        held[part] = derivative(slope, o.time[part]) * o.sample_time**2 / 24.0
    parts = [bench.bring(between), bench.bring(held), left_by_derivatives(bench, p)]
    return np.asarray(np.sqrt(np.sum(np.square(parts), axis=0)) * bench.counted)


def left_by_derivatives(bench: Workbench, p: Array) -> Array:
    """(K, n) in the analysis band: what wider polynomials make of the acceleration, times the inertias."""
    o, bent = bench.observation, np.zeros_like(bench.observation.q)
    for part in o.segments:
        wider = derivative(derivative(o.q[part], o.time[part], WIDER), o.time[part], WIDER)
        bent[part] = wider - o.qdd[part]
    inertia = bench.kernel.rows("mass_matrix_p", o.q, p)
    return np.asarray(bench.bring(np.einsum("kij,kj->ki", inertia, bent)) * bench.counted)


def left_at(turn: Array) -> Array:
    """The part of a second derivative that is such an error, of a motion of ``turn`` radians per sample."""
    return slope_gain(turn, WIDER) ** 2 - slope_gain(turn) ** 2
