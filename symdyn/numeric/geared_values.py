"""The numbers of an effect at another place that turns with it, geared: positions go further there, forces less far."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from symdyn.base.units import parse_unit
from symdyn.numeric.findings import Estimate, Finding
from symdyn.numeric.gearing import joint_of, reach
from symdyn.physics import catalogue
from symdyn.physics.effect import MOVING
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.places import places
from symdyn.spec.records import Motion, Robot


def geared(
    robot: Robot, effect: str, values: Mapping[str, Estimate], here: str, there: str
) -> dict[str, Estimate] | None:
    """What the same effect would be called at another part of the same joint's drive, if nothing between them twists.

    A force F(q, qd) at one place is F(q / r, qd / r) / r at another whose position is r q: each number is multiplied
    by a power of r that its units tell. For a rotational and a translational place they differ by a length, which is to
    a rack and its pinion what r is here. None where a law is tied to its place (by weight or by an angle from the
    vertical) or is none of motion, and where the two turn against each other, which makes another law of one that has
    a direction.
    """
    at, law = {place.address: place for place in places(robot)}, catalogue().get(effect)
    if law is None or not law.proposable or any(x not in at or at[x].kind not in MOVING for x in (here, there)):
        return None
    if law.reference_unit() is not None or joint_of(robot, here) != joint_of(robot, there):
        return None
    schemas = {schema.name: schema for schema in law.parameters}
    further = reach(robot, there) / reach(robot, here)
    if not further > 0.0:
        return None
    found = {}
    for name, told in values.items():
        power = _power(schemas[name])
        if power is None:
            return None
        factor = further**-power
        se = None if told.se is None else told.se * factor
        found[name] = Estimate(told.value * factor, se, schemas[name].units[at[there].motion])
    return found


def with_elsewhere(robot: Robot, finding: Finding) -> Finding:
    """The finding of a machine whose coordinates are its joints, with its numbers at rotors that are geared to it."""
    told = {
        place: values
        for place in finding.group
        if place != finding.place
        for values in [geared(robot, finding.effect, finding.parameters, finding.place, place)]
        if values is not None
    }
    return replace(finding, elsewhere=told)


def _power(schema: ParameterSchema) -> int | None:
    """Of the length by which its units for the two kinds of motion differ; None where it has but one of them."""
    units = schema.units
    if Motion.ROTATIONAL not in units or Motion.TRANSLATIONAL not in units:
        return None
    turning, sliding = (dict(parse_unit(units[m]).dimension) for m in (Motion.ROTATIONAL, Motion.TRANSLATIONAL))
    return turning.get("length", 0) - sliding.get("length", 0)
