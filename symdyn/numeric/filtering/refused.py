"""The likeliest hypothesis where free runs refuse it: its fit may be astray, or another effect be missing beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.numeric.filtering.afresh import relieved
from symdyn.numeric.filtering.budget import allowed
from symdyn.numeric.filtering.explain import Progress, step
from symdyn.numeric.filtering.judged import (
    EARNS,
    LEVEL,
    LIKELY,
    WORTH,
    Explanation,
    Step,
    certain,
    earns,
    heldout_p_value,
    improves,
    likelihood_p_value,
    worth,
)
from symdyn.numeric.filtering.model import Model

Pair = tuple[Step, Step]


def both(model: Model, current: Explanation, tried: Sequence[Step], progress: Progress) -> Pair | None:
    """Two effects that only help the motion together, though the first alone raises the likelihood beyond doubt.

    Coulomb friction without the Stribeck effect beside it, say, is fitted where the motion turns, and far off
    elsewhere.
    """
    first = next((each for each in tried if _sure(model, current, each)), None)
    if first is None or not allowed(f"what helps beside {first.score.candidate.label}"):
        return None
    second, _ = step(model, first.after, [], progress)
    if second is not None and second.after.heldout < (1.0 - 2.0 * EARNS) * current.heldout:
        return first, second
    return None


def reconsidered(
    model: Model, current: Explanation, best: Step, tried: Sequence[Step], progress: Progress
) -> tuple[Step | None, Pair | None]:
    """What explains more than ``best`` where a hypothesis is far likelier, and free runs refuse it: the same hypothesis
    fitted from the model as given, or with a second effect beside it; else ``best``.

    A fit beside which something is missing, or that began astray, is bent elsewhere: free runs then tell of that and
    not of the hypothesis, and what is taken in its place makes up for it.
    """
    likeliest = max(tried, key=lambda each: worth(model, each))
    if worth(model, best) >= LIKELY * worth(model, likeliest) or not _sure(model, current, likeliest):
        return best, None
    if not allowed(f"whether {likeliest.score.candidate.label} was refused for something else"):
        return best, None
    after = relieved(model, likeliest.after, progress)
    if after is not None:
        gain, p_value = current.fit.loss - after.fit.loss, heldout_p_value(current, after)
        likeliest = replace(likeliest, after=after, gain=gain, p_value=p_value)
        if earns(model, current, after, likeliest.score.candidate) and improves(best.after, after):
            return likeliest, None
    pair = both(model, current, (likeliest,), progress)
    if pair is None or pair[1].after.fit.loss > best.after.fit.loss or not improves(best.after, pair[1].after):
        return best, None
    return None, pair


def _sure(model: Model, current: Explanation, of: Step) -> bool:
    """Whether a hypothesis raises the likelihood beyond doubt, on held-out data too, and its size is certain."""
    return (
        worth(model, of) > WORTH
        and certain(model, of.after, of.score.candidate)
        and likelihood_p_value(current, of.after) < LEVEL
    )
