"""Two laws without a shape in place of one that has shapes: a curve of many numbers fits the sum of two plain ones.

Step by step the one that takes off most comes first. Of a linear and a hardening spring at one joint neither takes off
as much as a counterbalance spring, which resembles their sum.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from symdyn.base.errors import NumericalError
from symdyn.numeric.candidates import Candidate
from symdyn.numeric.explanation import LEVEL, Explanation
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.kinship import ready
from symdyn.numeric.nested import exchanged, explained_without, search_beside
from symdyn.numeric.regression import likelier, log_loss
from symdyn.numeric.together import Pair, pairs_without_shape


def pairs_instead(inquiry: Inquiry, places: Collection[str], progress: Callable[[str], None]) -> tuple[Inquiry, bool]:
    """The best such pair takes the place of a law with at least as many numbers where it explains more; and whether.

    Asked at ``places``.
    """
    swapped = False
    for curved, _ in inquiry.current.found:
        if curved.place.address not in places or not curved.shapes:
            continue
        progress(f"instead of {curved.label}: two simpler laws")
        rest = explained_without(inquiry, [curved])
        after = _better(inquiry, rest, _pairs(inquiry, rest, curved))
        if after is not None:
            new = [c for c, _ in after.found if all(c is not old for old, _ in rest.found)]
            names = " and ".join(c.title for c in new)
            told = f"{curved.label} gave way to {names}, which explain more in no more numbers"
            inquiry, swapped = exchanged(inquiry, [curved], rest, after).noting(told), True
    return inquiry, swapped


def _pairs(inquiry: Inquiry, rest: Explanation, curved: Candidate) -> list[Pair]:
    """Of laws at its place, of no more numbers together."""
    here = [c for c in ready(inquiry.setting.proposed, inquiry.case.robot, rest.effects) if c.place == curved.place]
    return [pair for pair in pairs_without_shape(here) if sum(c.size for c in pair) <= curved.size]


def _better(inquiry: Inquiry, rest: Explanation, pairs: Sequence[Pair]) -> Explanation | None:
    """The explanation with the pair of least error, where that is beyond chance less than what the curve leaves.

    Each of the two must earn its place beside the other: the curve may resemble one of them.
    """
    if not pairs:
        return None
    case, current, search = inquiry.case, inquiry.current, search_beside(inquiry, rest)
    pair = min(pairs, key=lambda each: log_loss(search.errors_beside(each)))
    try:
        after, *alone = (case.explain((*rest.found, *((c, ()) for c in each)), rest) for each in (pair, *zip(pair)))
    except NumericalError:
        return None
    if not all(case.earns(one, after) for one in alone):
        return None
    if any(case.bounded(c, after) for c in pair) or not all(case.certain(c, after) for c in pair):
        return None
    gain, p_value = likelier(current.training * current.weight, after.training * current.weight)
    falls = case.errors(after).heldout < case.errors(current).heldout
    return after if gain > 0.0 and p_value < LEVEL and falls else None
