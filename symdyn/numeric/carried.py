"""The load of each joint along a recording: what links, inertias and springs need, without the friction there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.candidates import Candidate, candidate
from symdyn.physics import catalogue, load_dependent
from symdyn.spec.places import places
from symdyn.spec.records import Monomial, PlaceKind, Robot

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Friction:
    """A friction that the model has at a joint, with its values as the file gives them."""

    law: Candidate
    values: tuple[tuple[str, Monomial], ...]

    def at(self, p: Array, index: dict[str, int]) -> dict[str, float]:
        """Numbers for its values under a parameter vector of the model."""
        return {
            name: float(value.coefficient) * math.prod(p[index[factor]] ** power for factor, power in value.factors)
            for name, value in self.values
        }


def frictions(robot: Robot) -> tuple[Friction, ...]:
    """Of all joints; one that depends on the load itself is none, for no other such law is asked for beside it."""
    at = {place.address: place for place in places(robot) if place.kind is PlaceKind.JOINT}
    found = []
    for spec in robot.effects:
        effect = catalogue()[spec.type]
        if not effect.dissipative or spec.at not in at or spec.type in load_dependent():
            continue
        counts = {p.name: float(dict(spec.values)[p.name].coefficient) for p in effect.parameters if p.is_count}
        found.append(Friction(candidate(effect, at[spec.at], counts), spec.values))
    return tuple(found)
