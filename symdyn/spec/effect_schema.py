"""What a reader must know of an effect to check a file: its name, where it attaches, its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from symdyn.spec.records import Motion, PlaceKind


class Scan(StrEnum):
    """How a diagnosis searches a shape parameter, which it cannot solve for linearly."""

    NONE = "none"
    SPEED = "speed"  # a characteristic speed: over the speeds that the recording holds
    ANGLE_ORDER = "angle_order"  # waves per revolution (or per metre times 2 pi)
    DISPLACEMENT = "displacement"  # a distance: up to that which the recording travels
    STEEPNESS = "steepness"  # one over a distance


@dataclass(frozen=True, slots=True)
class ParameterSchema:
    """One parameter of an effect: unit by kind of motion, null value, bounds, LaTeX, meaning."""

    name: str
    units: Mapping[Motion, str]
    latex: str
    meaning: str
    null: float | None = 0.0  # the value at which the effect vanishes exactly; None: any value does
    lower: float | None = None
    upper: float | None = None
    default: float | None = None  # None: must be given in a file
    zero_is_structural: bool = False  # a zero removes a state: it is no parameter, and no parameter may become zero
    is_count: bool = False  # a whole number that decides the structure, and is no parameter either
    scan: Scan = Scan.NONE
    relative_to: str | None = None  # the scan is of the ratio to that parameter, which scales the effect as a whole


@dataclass(frozen=True, slots=True)
class EffectSchema:
    """The face of an effect towards files and people."""

    identifier: str
    title: str
    attaches_to: frozenset[PlaceKind]
    parameters: tuple[ParameterSchema, ...]
