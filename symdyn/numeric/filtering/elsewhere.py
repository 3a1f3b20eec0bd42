"""The numbers of what was found, at the other places where the recording would have it: beyond a gear they differ."""

from __future__ import annotations

from dataclasses import replace

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.filtering.budget import allowed
from symdyn.numeric.filtering.conclude import parameters
from symdyn.numeric.filtering.discretisation import with_discretisation
from symdyn.numeric.filtering.explain import at_null
from symdyn.numeric.filtering.judged import ABOUT, Explanation, explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.locate import certainly_apart
from symdyn.numeric.filtering.model import Model, candidate_beliefs
from symdyn.numeric.filtering.reach import with_reach
from symdyn.numeric.filtering.stiff import rigid_with
from symdyn.numeric.findings import Estimate, Finding
from symdyn.numeric.geared_values import geared
from symdyn.numeric.groups import same_place
from symdyn.physics import catalogue


def with_elsewhere(model: Model, of: Explanation, finding: Finding) -> Finding:
    """The finding with its numbers at every other place of its group that turns with its own, but for a twist.

    Where no sample shows that twist they follow from the gear ratio. Elsewhere the effect is fitted there in its own
    place's stead; where it does not do as well any more, beside all that was found since, nothing is told.
    """
    if finding.effect not in catalogue():  # a part that the machine got
        return finding
    told: dict[str, dict[str, Estimate]] = {}
    rigid = {finding.place, *rigid_with(model, of, finding.place, finding.effect)}
    for place in finding.group:
        values = geared(model.robot, finding.effect, finding.parameters, finding.place, place)
        if place == finding.place or values is None:
            continue
        if same_place(model.robot, place)[-1] in rigid:
            told[place] = values
        elif (fitted := _fitted(model, of, finding, place, values)) is not None:
            told[place] = fitted
    return replace(finding, elsewhere=told)


def _fitted(
    model: Model, of: Explanation, finding: Finding, place: str, values: dict[str, Estimate]
) -> dict[str, Estimate] | None:
    """Its numbers there, with all else fitted anew; ``values`` begin."""
    mine = next((item for item in of.found if _is(item[0], finding.effect, finding.place)), None)
    there = next((c for c in model.proposed if _is(c, finding.effect, place)), None)
    if mine is None or there is None or not allowed(f"the numbers of {finding.title} at {place}"):
        return None
    p, others = at_null(model, of, mine[0])
    for schema in (*there.linear, *there.shapes):
        p[of.fit.bench.index[there.parameter(schema)]] = values[schema.name].value
    shape = values[there.shapes[0].name].value if mine[1] is not None and there.shapes else None
    beliefs = dict(others) | candidate_beliefs(there, shape)
    found = tuple((there, shape) if item is mine else item for item in of.found)
    after = explained(model, found, beliefs, fit(of.fit.bench, p, beliefs))
    worse = after.fit.loss > of.fit.loss and certainly_apart(after.score, of.score)
    if worse or after.heldout > (1.0 + ABOUT) * of.heldout:
        return None
    told = [there.parameter(schema) for schema in (*there.linear, *there.shapes)]
    return parameters(model, replace(after, fit=with_reach(with_discretisation(after.fit), told)), there)


def _is(candidate: Candidate, effect: str, place: str) -> bool:
    return (candidate.effect, candidate.place.address) == (effect, place)
