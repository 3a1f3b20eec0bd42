"""What is planted: the numbers that a plant gets, and the answers that name it right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from benchmarks.blind.laws import COLUMN, WIDTH
from benchmarks.blind.machine import Place

Form = Mapping[str, Mapping[str, float]]  # effect -> parameter -> true value


@dataclass(frozen=True)
class Planted:
    """One concealed effect at one place.

    ``forms`` are the answers that are right: sets of effects, with the values of those parameters that a recording can
    tell, whose equations are the same as the plant's. Without any the effect is one that no catalogue holds.
    """

    kind: str
    place: str
    row: Mapping[str, float] = field(default_factory=dict)  # numbers of the laws at a moving coordinate
    plant: Mapping[str, float] = field(default_factory=dict)  # numbers of a shaft, a circuit, a limit
    fault: tuple[str, Mapping[str, float]] | None = None  # of a sensor: its channel and what is wrong
    forms: tuple[Form, ...] = ()
    omitted: frozenset[str] = frozenset()  # lines that the model handed over does not have
    replaces: str = ""  # of the machine's own laws at the place: "viscous" or "dry"
    also_at: tuple[str, ...] = ()  # addresses that name the same coordinate
    problems: tuple[str, ...] = ()  # codes of what a tool may refuse the recording for instead
    scored: Mapping[str, float] | None = None  # where a recording cannot tell the first form's values one by one
    blemish: bool = False  # of the recording alone: refused for its problems, or without any lived with

    @property
    def known(self) -> bool:
        return bool(self.forms)


def rows(planted: Sequence[Planted], places: Sequence[Place], own: Sequence[Mapping[str, float]]) -> np.ndarray:
    """One row of ``laws`` for each moving place, in their order: the machine's own laws, and what is planted."""
    out = np.zeros((len(own), WIDTH))
    moving = [place.address for place in places if place.kind in ("joint", "inertia")]
    for i, values in enumerate(own):
        here = [plant for plant in planted if plant.place == moving[i]]
        gone = {plant.replaces for plant in here}
        for name, value in values.items():
            if ("viscous" if name == "viscous" else "dry") not in gone:
                out[i, COLUMN[name]] = value
        for plant in here:
            for name, value in plant.row.items():
                out[i, COLUMN[name]] += value
    return out
