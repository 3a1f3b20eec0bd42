"""Which effects a diagnosis may propose, and which parameters of a model a fit may move."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import product

from symdyn.base.errors import Problem, UsageError
from symdyn.base.wording import did_you_mean, quoted
from symdyn.physics import catalogue, load_dependent
from symdyn.physics.effect import Effect
from symdyn.spec.effect_schema import ParameterSchema, Scan
from symdyn.spec.places import places
from symdyn.spec.records import DHRow, Monomial, Place, PlaceKind, Robot

Key = tuple[str, str, int]  # effect, place, and the how manieth of its kind there

GRAVITY = "gravity"  # what no fit moves, but a diagnosis may doubt
AT = 1e-6  # of a bound, within which a fit ends there


@dataclass(frozen=True, slots=True)
class Candidate:
    """One effect at one place; ``linear`` parameters are solved for, ``shapes`` are searched.

    ``taken`` ones have one value each, which no motion and effort could tell, or which makes this candidate.
    ``number`` counts those of its kind that are there: a wave may be one of several, most laws are there once.
    """

    effect: str
    title: str
    place: Place
    linear: tuple[ParameterSchema, ...]
    shapes: tuple[ParameterSchema, ...]
    builds_on: str | None
    taken: tuple[tuple[ParameterSchema, float], ...] = ()
    number: int = 1

    @property
    def key(self) -> Key:
        return self.effect, self.place.address, self.number

    @property
    def repeats(self) -> bool:
        """Whether a place may have several of it: waves of different orders."""
        return [schema.scan for schema in self.shapes] == [Scan.ANGLE_ORDER]

    def name_of(self, parameter: str) -> str:
        """What it is called in a robot with this effect, by its name in the effect's declaration."""
        return next(self.parameter(s) for s in (*self.linear, *self.shapes) if s.name == parameter)

    def parameter(self, schema: ParameterSchema) -> str:
        """A name for the parameter that no other place or effect has."""
        which = f"_{self.number}" if self.number > 1 else ""
        return f"{self.place.address.replace('.', '_')}_{self.effect}_{schema.name}{which}"

    def unit(self, schema: ParameterSchema) -> str:
        return schema.units[self.place.motion]

    def values(self, coefficients: Sequence[float], shapes: Sequence[float]) -> dict[str, float]:
        """The effect's parameters by name; what is searched as a ratio follows the one it is relative to."""
        found = {schema.name: float(value) for schema, value in zip(self.linear, coefficients, strict=True)}
        for schema, value in zip(self.shapes, shapes, strict=True):
            turned = math.remainder(float(value), 2.0 * math.pi) if schema.scan is Scan.ANGLE else float(value)
            found[schema.name] = turned * self.scale(schema, found)
        return found | {schema.name: value for schema, value in self.taken}

    @staticmethod
    def scale(schema: ParameterSchema, values: Mapping[str, float]) -> float:
        """What a searched number is multiplied by to be the parameter."""
        if schema.relative_to is None:
            return 1.0
        base = values[schema.relative_to]
        return base if not schema.inversely else (1.0 / base if base else math.inf)

    @property
    def counts(self) -> tuple[tuple[str, float], ...]:
        """Whole numbers that make it another law."""
        return tuple((schema.name, value) for schema, value in self.taken if schema.is_count)

    @property
    def swings(self) -> bool:
        """Whether it has a frequency of its own, and so answers to the whole motion."""
        return any(schema.scan is Scan.FREQUENCY for schema in self.shapes)

    @property
    def size(self) -> int:
        """How many numbers it brings."""
        return len(self.linear) + len(self.shapes)

    @property
    def law(self) -> str:
        """What it shares with all others of its kind at its place."""
        return f"{self.effect}{self._which} at {self.place.address}"

    @property
    def named(self) -> str:
        return self.title if self.number == 1 else f"{self.title} no. {self.number}"

    @property
    def label(self) -> str:
        return f"{self.named}{self._which} at {self.place.address}"

    @property
    def _which(self) -> str:
        return "".join(f" ({name} {value:g})" for name, value in self.counts)


def candidates(robot: Robot) -> tuple[Candidate, ...]:
    """Every proposable effect at every joint where the robot does not have it yet."""
    present = {(e.type, e.at) for e in robot.effects}
    passive = {joint.name for joint in robot.joints if joint.passive}
    found = []
    for place in places(robot):
        if place.kind is not PlaceKind.JOINT:  # the measured places; rigid rotors move with their joint
            continue
        for effect in catalogue().values():
            if not effect.proposable or place.kind not in effect.attaches_to or place.motion not in effect.motions:
                continue
            if effect.reference_unit() is not None:  # it drives no joint whose effort is known
                continue
            if (effect.identifier, place.address) in present:
                continue
            if effect.identifier in load_dependent() and place.address in passive:  # its friction is all its load
                continue
            found += [candidate(effect, place, counts) for counts in counts_of(effect)]
    return tuple(found)


def candidate(effect: Effect, place: Place, counts: Mapping[str, float]) -> Candidate:
    """The effect at a place, with these whole numbers."""
    free = [p for p in effect.parameters if not p.is_count]
    linear = tuple(p for p in free if p.scan is Scan.NONE)
    shapes = tuple(p for p in free if p.scan not in (Scan.NONE, Scan.ASSUMED))
    taken = [(p, p.tried[0]) for p in free if p.scan is Scan.ASSUMED]
    taken += [(p, counts[p.name]) for p in effect.parameters if p.is_count]
    return Candidate(effect.identifier, effect.title, place, linear, shapes, effect.builds_on, tuple(taken))


def counts_of(effect: Effect) -> list[dict[str, float]]:
    """All combinations of the whole numbers to be tried; one, without any, for most effects."""
    whole = [p for p in effect.parameters if p.is_count]
    return [dict(zip((p.name for p in whole), values, strict=True)) for values in product(*(p.tried for p in whole))]


def fitted_parameters(robot: Robot, scaled: bool = True) -> tuple[str, ...]:
    """The model's own parameters that a fit may move: inertial ones (the tool's too) and those of its effects.

    Geometry, gravity and actuator gains are taken as known: the recording is read through them. Where no
    effort was measured (not ``scaled``), masses and their centres are, too.
    """
    moving: list[Monomial] = [value for e in robot.effects for _, value in e.values]
    fixed: list[Monomial] = list(robot.gravity)
    if robot.base is not None:
        fixed += robot.base.position
    if robot.tool is not None:
        fixed += robot.tool.placement.position
    links = [joint.link for joint in robot.joints] + ([robot.tool.link] if robot.tool is not None else [])
    for link in links:
        (moving if scaled else fixed).extend([link.mass, *link.com])
        moving += link.inertia
    for joint in robot.joints:
        place = joint.placement
        fixed += [place.theta, place.d, place.a, place.alpha] if isinstance(place, DHRow) else place.position
        if joint.actuator is not None:
            fixed.append(joint.actuator.gain)
        if joint.drive is not None:
            fixed.append(joint.drive.ratio)
            moving += [rotor.inertia for rotor in joint.drive.rotors]
    names = {name for monomial in moving for name, _ in monomial.factors}
    names -= {name for monomial in fixed for name, _ in monomial.factors}
    return tuple(p.name for p in robot.parameters if p.name in names)


def held_parameters(robot: Robot, names: Sequence[str], patterns: Sequence[str]) -> frozenset[str]:
    """Those of the ``names`` that a fit may move which it shall not: ``*`` stands for any, but gravity has to be named.

    UsageError (SD010) for a pattern that means none.
    """
    held: set[str] = set()
    for pattern in patterns:
        meant = [name for name in names if fnmatchcase(name, pattern)] + [GRAVITY] * (pattern == GRAVITY)
        if not meant:
            hint = did_you_mean(pattern, names, "parameters that a fit moves")
            raise UsageError(
                Problem("SD010", f"no fit of '{robot.name}' moves a parameter {quoted(pattern)}", hint=hint)
            )
        held.update(meant)
    return frozenset(held)


def bounds(robot: Robot) -> dict[str, tuple[float, float]]:
    """(lower, upper) of the model's own parameters: masses, moments of inertia, what effects declare.

    The lower bound is a thousandth of the model's value where zero would make the mass matrix singular.
    """
    values = {p.name: p.value or 0.0 for p in robot.parameters}
    positive: list[Monomial] = []
    for joint in robot.joints:
        positive += [joint.link.mass, *joint.link.inertia[:3]]
        positive += [rotor.inertia for rotor in (joint.drive.rotors if joint.drive else ())]
    if robot.tool is not None:
        positive += [robot.tool.link.mass, *robot.tool.link.inertia[:3]]
    found = {
        m.factors[0][0]: (1e-3 * abs(values[m.factors[0][0]]), math.inf)
        for m in positive
        if len(m.factors) == 1 and m.factors[0][1] == 1 and m.coefficient > 0
    }
    for effect in robot.effects:
        schemas = {p.name: p for p in catalogue()[effect.type].parameters}
        for name, value in effect.values:
            if len(value.factors) == 1 and value.factors[0][1] == 1 and value.coefficient > 0:
                found[value.factors[0][0]] = _limits(schemas[name])
    return found


def candidate_bounds(candidate: Candidate) -> dict[str, tuple[float, float]]:
    """Bounds of a candidate's linear parameters."""
    return {candidate.parameter(schema): _limits(schema) for schema in candidate.linear}


def bounded(candidate: Candidate, coefficients: Sequence[float]) -> tuple[ParameterSchema, ...]:
    """Linear parameters that a fit within bounds left at one of them, where they do not vanish: it would go further."""
    return tuple(
        schema
        for schema, value in zip(candidate.linear, coefficients, strict=True)
        for bound in (schema.lower, schema.upper)
        if bound is not None and bound != (schema.null or 0.0) and math.isclose(value, bound, rel_tol=AT)
    )


def _limits(schema: ParameterSchema) -> tuple[float, float]:
    lower = -math.inf if schema.lower is None else schema.lower
    return lower, math.inf if schema.upper is None else schema.upper
