"""The motion and efforts behind what the channels of the joints show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from symdyn.numeric.observation import Observation, smoothed
from symdyn.numeric.reading import Reading


def read(seen: Observation, readings: Sequence[Reading]) -> Observation:
    """The motion and efforts behind what was shown; ``readings`` joint by joint."""
    if all(reading == Reading() for reading in readings):
        return seen
    names = ("gain", "offset", "effort_gain", "limit")
    gain, offset, factor, limit = (np.array([getattr(r, name) for r in readings]) for name in names)
    seen = _smoothed(seen, readings)
    return replace(
        seen,
        q=(seen.q - offset) / gain,
        qd=seen.qd / gain,
        qdd=seen.qdd / gain,
        quick=None if seen.quick is None else seen.quick / gain,
        measured=(seen.measured - offset) / gain,
        noise=seen.noise / gain**2,
        tau=np.clip(factor * _advanced(seen, readings), -limit, limit),
        factor=None if np.all(factor == 1.0) else factor,
    )


def _advanced(seen: Observation, readings: Sequence[Reading]) -> NDArray[np.float64]:
    """(N, n) efforts as they were when the motion was; at the end of a stretch the last one stays."""
    tau = seen.tau.copy()
    for part in seen.segments:
        time = seen.time[part]
        for i, late in enumerate(r.late for r in readings):
            if late:
                tau[part, i] = CubicSpline(time, seen.tau[part, i])(np.clip(time + late, time[0], time[-1]))
    return tau


def _smoothed(seen: Observation, readings: Sequence[Reading]) -> Observation:
    """The motion of each joint below the frequency that its reading says."""
    below = tuple(r.motion for r in readings)
    if min(below) >= seen.cutoff:
        return seen
    shown = {name: getattr(seen, name).copy() for name in ("q", "qd", "qdd")}
    for i, motion in enumerate(below):
        for values in shown.values() if motion < seen.cutoff else ():
            values[:, i] = smoothed(values[:, i], seen.segments, seen.rate, motion)
    return replace(seen, **shown, below=below, quick=seen.qd)
