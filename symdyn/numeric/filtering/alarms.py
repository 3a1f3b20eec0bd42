"""What a diagnosis by filter warns of beside its findings: numbers that went too far, and numbers that nothing told."""

from __future__ import annotations

import math
from collections.abc import Sequence

from symdyn.numeric.explanation import FAR
from symdyn.numeric.filtering.judged import Explanation
from symdyn.numeric.filtering.likelihood import MLFit
from symdyn.numeric.filtering.model import Model
from symdyn.numeric.filtering.places import latent_at
from symdyn.numeric.filtering.travel import Travel, travel
from symdyn.numeric.findings import Finding
from symdyn.physics import catalogue
from symdyn.spec.effect_schema import ParameterSchema, Scan

GROWN = 2.0  # of the travel: within so much a thing that grows by itself still shows that it does


def moved(model: Model, of: MLFit) -> list[str]:
    """Parameters that went where no data sheet is wrong: they may be absorbing what the model lacks."""
    told = []
    for name, belief in model.beliefs.items():
        value = float(of.p[of.bench.index[name]])
        if belief.positive and abs(math.log(value) - belief.centre) > FAR * belief.spread:
            told.append(
                f"{name} went from {math.exp(belief.centre):.3g} to {value:.3g}: it may be absorbing missing structure"
            )
        if belief.like in model.beliefs:
            other = float(of.p[of.bench.index[belief.like]])
            if abs(math.log(value / other)) > FAR * belief.apart:
                told.append(
                    f"{name} is {value / other:.3g} times {belief.like}, and of one motor both are the same in SI: "
                    "one is for other currents or voltages than those recorded, or it absorbs missing structure"
                )
    return told


def out_of_reach(model: Model, of: Explanation) -> list[str]:
    """Characteristic speeds and distances of effects that were found which no motion comes to: it tells no such law."""
    told = []
    for candidate, _ in of.found:
        latent = latent_at(model.latents, candidate.place.address)
        if latent is None or not latent.motion.any():
            continue
        at = travel(of, latent)
        for schema in (*candidate.linear, *candidate.shapes):
            value, most = float(of.fit.p[of.fit.bench.index[candidate.parameter(schema)]]), reach(schema, at)
            if value > most:
                unit = candidate.unit(schema)
                told.append(
                    f"{schema.name} of {candidate.label} is {value:.3g} {unit}, and what occurs there ends at "
                    f"{most:.3g} {unit}: the law bends where nothing was recorded, and may stand for other missing "
                    "structure"
                )
    return told


def reach(schema: ParameterSchema, at: Travel) -> float:
    """Up to where a place that moves like that tells such a parameter."""
    if schema.scan in (Scan.SPEED, Scan.TURNOVER):
        return at.fastest
    if schema.scan is Scan.DISPLACEMENT:
        return at.width
    return GROWN * at.width if schema.scan is Scan.GROWTH else math.inf


def without_interval(findings: Sequence[Finding]) -> list[str]:
    """Findings of which no number has an interval: that they are there is told, their size is not."""
    told = []
    for each in findings:
        known = catalogue().get(each.effect)  # a part that the machine got is none
        given = {p.name for p in known.parameters if p.is_count or p.scan is Scan.ASSUMED} if known else set()
        own = {name: x for name, x in each.parameters.items() if name not in given}
        if own and all(x.se is None for x in own.values()):
            values = ", ".join(f"{name} (about {x.value:.2g} {x.unit})" for name, x in own.items())
            told.append(f"{each.title} at {each.place}: these recordings do not tell its {values}; it may be anything")
    return told
