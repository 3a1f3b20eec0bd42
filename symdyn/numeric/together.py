"""Two effects at one place that explain something only together: beside the model's parameters each hides the other."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from symdyn.base.errors import NumericalError
from symdyn.numeric.candidates import Candidate
from symdyn.numeric.explanation import LEVEL, Explanation
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.kinship import akin
from symdyn.numeric.regression import likelier, log_loss
from symdyn.numeric.search import Search

BEST = 3  # pairs that are fitted
Pair = tuple[Candidate, Candidate]


def pair_that_earns(inquiry: Inquiry, search: Search, proposed: Sequence[Candidate]) -> tuple[Pair, Explanation] | None:
    """The best pair that held-out data confirm, where no effect does by itself.

    Dry friction and quadratic drag, fitted by viscous friction, leave the opposite of one another. Pairs are those of
    laws without a shape; each of the two must be within its bounds, and its size certain.
    """
    pairs = pairs_without_shape(proposed)
    tried = []
    for pair in pairs:
        errors = search.errors_beside(pair)
        gain, p_value = likelier(search.errors, errors)
        if gain > 0 and p_value * len(pairs) < LEVEL:
            tried.append((log_loss(errors), pair))
    for _, pair in sorted(tried, key=lambda item: item[0])[:BEST]:
        case, current = inquiry.case, inquiry.current
        try:
            after = case.explain((*current.found, *((c, ()) for c in pair)), current)
        except NumericalError:
            continue
        bounded = any(case.bounded(c, after) for c in pair)
        if not bounded and all(case.certain(c, after) for c in pair) and case.earns(current, after):
            return pair, after
    return None


def pairs_without_shape(proposed: Sequence[Candidate]) -> list[Pair]:
    """Of laws at one place, neither of which contains the other."""
    simple = [c for c in proposed if not c.shapes]
    return [(a, b) for a, b in combinations(simple, 2) if a.place == b.place and not akin(a.effect, b.effect)]
