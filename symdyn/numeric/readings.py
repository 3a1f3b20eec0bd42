"""How the channels of a joint show its motion and effort: scaled, shifted, or as asked for and not as given."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from symdyn.numeric.observation import Observation, smoothed
from symdyn.spec.monomials import value_of
from symdyn.spec.records import Robot

READERS = {  # effects: their parameters, and what a reading calls them
    "encoder": {"gain": "gain", "offset": "offset"},
    "effort_gain": {"gain": "effort_gain"},
    "effort_saturation": {"limit": "limit"},
}


@dataclass(frozen=True, slots=True)
class Reading:
    """Of one joint: position shown = ``gain`` * position + ``offset``.

    ``effort_gain`` times the effort shown was given, and no more than ``limit``.
    """

    gain: float = 1.0
    offset: float = 0.0
    limit: float = math.inf
    motion: float = math.inf  # Hz: where its motion sinks into the encoder's steps; positions are smoothed below that
    late: float = 0.0  # s: its effort was recorded that much later than its motion
    effort_gain: float = 1.0


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
        measured=(seen.measured - offset) / gain,
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
    return replace(seen, **shown, below=below)


def declared(robot: Robot) -> tuple[Reading, ...]:
    """What the robot's own encoders and limits say of each joint."""
    numbers = {p.name: p.value for p in robot.parameters}
    found = []
    for joint in robot.joints:
        told: dict[str, float] = {}
        for effect in robot.effects:
            if effect.at == joint.name:
                fields = READERS.get(effect.type, {})
                told |= {fields[name]: value_of(m, numbers) or 0.0 for name, m in effect.values if name in fields}
        found.append(Reading(**told))
    return tuple(found)
