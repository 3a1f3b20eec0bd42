"""Two effects that were found on one drive, and a law of fewer numbers that does what both do.

Step by step the one that helps most comes first, and what it lacks is made up for by another: a linear spring is what a
hardening one looks like at first, and a ripple of few waves what it lacks then.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.filtering.budget import allowed
from symdyn.numeric.filtering.explain import Progress, at_null, begun, fitted, ready, shaped
from symdyn.numeric.filtering.judged import (
    LEVEL,
    WORTH,
    Explanation,
    Step,
    certain,
    explained,
    heldout_p_value,
    improves,
    likelihood_p_value,
    price,
)
from symdyn.numeric.filtering.late import absorbing, put_back
from symdyn.numeric.filtering.likelihood import MLFit, fit
from symdyn.numeric.filtering.model import Model, as_it_begins, candidate_beliefs
from symdyn.numeric.filtering.score import Left, Score, scores
from symdyn.numeric.filtering.side_by_side import side_by_side
from symdyn.numeric.filtering.telling import finding
from symdyn.numeric.findings import Finding
from symdyn.numeric.gearing import joint_name

TRIED = 2  # laws that are fitted in place of a pair
PROMISES = 0.5  # of what both bring, to first order: what promises less is not fitted

Pair = tuple[tuple[Candidate, float | None], tuple[Candidate, float | None]]


def in_one_law(
    model: Model, current: Explanation, findings: Sequence[Finding], progress: Progress
) -> tuple[Explanation, list[Finding], bool]:
    """The explanation with one law in the place of two, where that is as good for its numbers; and whether any is."""
    for pair in _pairs(current):
        labels = " and ".join(c.label for c, _ in pair)
        if not allowed(f"one law in the place of {labels}"):
            break
        progress(f"instead of {labels}: one law")
        rest, chosen = _instead(model, current, pair, progress)
        if chosen is not None:
            progress(f"as good as {labels}: {chosen.score.candidate.title}")
            return chosen.after, _told(model, rest, chosen, pair, findings), True
    return current, list(findings), False


def _pairs(current: Explanation) -> Iterator[Pair]:
    """Those on one drive, on neither of which anything else builds."""
    bases = {(c.builds_on, joint_name(c.place.address)) for c, _ in current.found}
    free = [item for item in current.found if (item[0].effect, joint_name(item[0].place.address)) not in bases]
    for one, other in combinations(free, 2):
        if joint_name(one[0].place.address) == joint_name(other[0].place.address):
            yield one, other


def _instead(model: Model, current: Explanation, pair: Pair, progress: Progress) -> tuple[Explanation, Step | None]:
    """What was found beside a pair, and the likeliest law in its place, if it does as well for its numbers.

    Asked with the noise that the pair leaves: where more is missing, an unknown force would do the work of any law.
    """
    rest = _without(model, current, pair)
    bench, p, beliefs = rest.fit.bench, rest.fit.p, rest.beliefs
    ranked = scores(bench, p, tuple(beliefs), _smaller(model, rest, pair))
    both = Left.of(bench, p, tuple(beliefs)).power - float(np.sum(bench.filtered(current.fit.p).white ** 2))
    promising = [s for s in ranked if s.gain > max(WORTH, PROMISES * both / 2.0)][:TRIED]

    def begin(score: Score) -> MLFit:
        start = shaped(bench, p, score.candidate, score.shape)
        own = dict(beliefs) | candidate_beliefs(score.candidate, score.shape)
        starts = [(bench, begun(bench, start, score.candidate, score.estimate))]
        if absorbing(rest):  # the pair may have bent more than itself
            first = as_it_begins(model, bench)
            starts.append((first, begun(first, put_back(rest, start), score.candidate, score.estimate)))
        return min(side_by_side(lambda each: fit(*each, own), starts), key=lambda each: each.loss)

    tried = fitted(model, rest, promising, progress, begin)
    good = [s for s in tried if certain(model, s.after, s.score.candidate) and _as_good(model, current, pair, s)]
    return rest, min(good, key=lambda s: s.after.fit.loss + price(model, s.score.candidate), default=None)


def _without(model: Model, current: Explanation, pair: Pair) -> Explanation:
    """Nothing is fitted again."""
    rest = current
    for item in pair:
        p, beliefs = at_null(model, rest, item[0])
        found = tuple(other for other in rest.found if other is not item)
        rest = replace(rest, found=found, beliefs=beliefs, fit=replace(rest.fit, p=p))
    return rest


def _smaller(model: Model, rest: Explanation, pair: Pair) -> list[Candidate]:
    """Laws on their drive with fewer numbers than both; neither of the two, which had to earn its place."""
    drive, numbers = joint_name(pair[0][0].place.address), sum(c.size for c, _ in pair)
    asked = {(c.effect, c.place.address) for c, _ in pair}
    return [
        c
        for c in ready(model, rest)
        if joint_name(c.place.address) == drive and c.size < numbers and (c.effect, c.place.address) not in asked
    ]


def _as_good(model: Model, current: Explanation, pair: Pair, one: Step) -> bool:
    """Whether one law is as likely as the two for its numbers, and free runs do not tell otherwise.

    Where it is likelier in spite of them, on data held out no less, free runs have no say.
    """
    had = current.fit.loss + sum(price(model, c) for c, _ in pair)
    if one.after.fit.loss + price(model, one.score.candidate) > had:
        return False
    likelier = one.after.fit.loss < current.fit.loss - WORTH and likelihood_p_value(one.after, current) >= LEVEL
    return likelier or not improves(one.after, current)


def _told(model: Model, rest: Explanation, chosen: Step, pair: Pair, findings: Sequence[Finding]) -> list[Finding]:
    """The law where the first of the pair was told, with all that the two told."""
    at = {(c.effect, c.place.address) for c, _ in pair}
    first, second = (f for f in findings if (f.effect, f.place) in at)
    before = explained(model, rest.found, rest.beliefs, fit(rest.fit.bench, rest.fit.p, rest.beliefs))
    gain, p_value = before.fit.loss - chosen.after.fit.loss, heldout_p_value(before, chosen.after)
    new = finding(model, before, replace(chosen, gain=gain, p_value=p_value), (chosen,))
    return [new if f is first else f for f in findings if f is not second]
