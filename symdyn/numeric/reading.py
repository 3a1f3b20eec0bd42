"""How the channels of a joint show its motion and effort: scaled, shifted, or as asked for and not as given."""

from __future__ import annotations

import math
from dataclasses import dataclass

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
