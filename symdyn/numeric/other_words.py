"""Laws at one place that are together one law of another name: no motion would tell the two accounts apart."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from symdyn.numeric.explanation import CERTAIN
from symdyn.numeric.findings import Diagnosis, Estimate, Finding, SameLaw
from symdyn.physics import catalogue
from symdyn.physics.effect import Effect
from symdyn.spec.monomials import value_of
from symdyn.spec.places import places

Parts = dict[str, dict[str, Estimate]]  # by effect and parameter


def in_other_words(diagnosis: Diagnosis) -> Diagnosis:
    """Every finding with the laws that it is, together with what else the diagnosed model has at its place."""
    return replace(diagnosis, findings=tuple(_named(diagnosis, finding) for finding in diagnosis.findings))


def _named(diagnosis: Diagnosis, finding: Finding) -> Finding:
    laws = [(law, names) for law in catalogue().values() for names in law.sums if finding.effect in names]
    told = (_together(law, _parts(diagnosis, finding.place, names), diagnosis, finding) for law, names in laws)
    return replace(finding, same_as=tuple(each for each in told if each is not None))


def _parts(diagnosis: Diagnosis, place: str, names: tuple[str, ...]) -> Parts:
    """What the diagnosed model has of these effects at a place; {} unless it has each of them, once."""
    values = {parameter.name: parameter.value for parameter in diagnosis.diagnosed.parameters}
    here = [e for e in diagnosis.diagnosed.effects if e.at == place and e.type in names]
    if sorted(e.type for e in here) != sorted(names):
        return {}
    found = {f.effect: f.parameters for f in diagnosis.findings if f.place == place}
    return {
        e.type: {
            name: found.get(e.type, {}).get(name, Estimate(value_of(value, values) or 0.0, None, ""))
            for name, value in e.values
        }
        for e in here
    }


def _together(law: Effect, parts: Parts, diagnosis: Diagnosis, finding: Finding) -> SameLaw | None:
    """What these are if they are that law. Standard errors count the parts as independent of each other."""
    if not parts:
        return None
    # What is not told from nothing makes no other law of the rest.
    certain = {
        effect: {name: e.value if e.se is None or abs(e.value) > CERTAIN * e.se else 0.0 for name, e in own.items()}
        for effect, own in parts.items()
    }
    summed = law.summed(certain)
    if summed is None:
        return None
    variance = dict.fromkeys(summed, 0.0)
    for effect, own in parts.items():
        for name, e in own.items():
            moved = law.summed({**certain, effect: {**certain[effect], name: certain[effect][name] + (e.se or 0.0)}})
            for key in summed:
                variance[key] += ((moved or summed)[key] - summed[key]) ** 2
    motion = next(place.motion for place in places(diagnosis.robot) if place.address == finding.place)
    units = {schema.name: schema.units[motion] for schema in law.parameters}
    numbers: Mapping[str, Estimate] = {
        key: Estimate(value, math.sqrt(variance[key]) or None, units[key]) for key, value in summed.items()
    }
    beside = tuple(effect for effect in parts if effect != finding.effect)
    return SameLaw(law.identifier, finding.place, beside, numbers)
