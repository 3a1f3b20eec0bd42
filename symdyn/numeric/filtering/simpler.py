"""A law that was found, and one that it contains: beside the rest, the simpler may do as well."""

from __future__ import annotations

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.filtering.explain import Progress, fitted, without_effect
from symdyn.numeric.filtering.judged import WORTH, Explanation, Step, improves, price
from symdyn.numeric.filtering.model import Model
from symdyn.numeric.filtering.score import scores
from symdyn.physics import catalogue


def simpler(
    model: Model, current: Explanation, item: tuple[Candidate, float | None], progress: Progress
) -> tuple[Explanation, Step] | None:
    """The explanation without a law, and a simpler one in its place; None where the law is needed.

    What was fitted beside a law when it was found may have been astray, and what it has more than another one with it.
    Asked only where one of its numbers would not have earned its price by itself.
    """
    wide = item[0]
    contained = catalogue()[wide.effect].generalises
    less = [c for c in model.proposed if c.place == wide.place and c.effect in contained and c.size < wide.size]
    if not less or _sure(model, current, wide):
        return None
    without = without_effect(model, current, item)
    ranked = scores(without.fit.bench, without.fit.p, tuple(without.beliefs), less)
    tried = fitted(model, without, ranked[:1], progress)
    instead = min(tried, key=lambda step: step.after.fit.loss, default=None)
    if instead is None:
        return None
    more = price(model, wide) - price(model, instead.score.candidate)
    if instead.after.fit.loss - current.fit.loss >= WORTH + more and improves(instead.after, current):
        return None
    return without, instead


def _sure(model: Model, current: Explanation, of: Candidate) -> bool:
    """Whether every number that it is linear in raises the likelihood by what a law must."""
    covariance, index, names = current.fit.covariance, current.fit.bench.index, current.fit.names
    least = WORTH + price(model, of) / of.size
    for schema in of.linear:
        i = names.index(of.parameter(schema))
        off = current.fit.p[index[names[i]]] - (schema.null or 0.0)
        if 0.5 * off**2 < least * covariance[i, i]:
            return False
    return True
