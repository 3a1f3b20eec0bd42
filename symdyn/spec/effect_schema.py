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
    TURNOVER = "turnover"  # a speed at which a curve bends: no less than what tells it from a jump
    FREQUENCY = "frequency"  # of something that swings: about the band in which there is a mismatch
    DAMPING = "damping"  # of that: between the values in ``tried``, of which the last is no swinging any more
    ANGLE_ORDER = "angle_order"  # waves per revolution (or per metre times 2 pi)
    DISPLACEMENT = "displacement"  # a distance: up to that which the recording travels
    GROWTH = "growth"  # a distance within which something grows by itself: about that which the recording travels
    STEEPNESS = "steepness"  # one over a distance
    SLOWNESS = "slowness"  # one over a speed
    ANGLE = "angle"  # a direction: the whole turn
    VALUES = "values"  # a plain ratio: the values in ``tried``
    HEAT = "heat"  # a heat capacity per coefficient of viscous friction, by the rises in ``tried`` at the end
    HEATING = "heating"  # a thermal resistance times that, by the rises in ``tried`` after very long
    ASSUMED = "assumed"  # not at all: motion and effort tell only its product with another one; ``tried`` holds it


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
    nonzero: bool = False  # what is divided by: a sensor that shows nothing tells nothing
    is_count: bool = False  # a whole number that decides the structure, and is no parameter either
    scan: Scan = Scan.NONE
    relative_to: str | None = None  # the scan is of the ratio to that parameter, which scales the effect as a whole
    inversely: bool = False  # of the product with it, then
    tried: tuple[float, ...] = ()  # of a plain ratio, a count, or what is assumed


@dataclass(frozen=True, slots=True)
class EffectSchema:
    """The face of an effect towards files and people."""

    identifier: str
    title: str
    attaches_to: frozenset[PlaceKind]
    parameters: tuple[ParameterSchema, ...]
    reference: str | Mapping[Motion, str] | None = None  # of a servo loop: the unit of what it follows
