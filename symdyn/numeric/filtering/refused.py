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


def fitted_anew(
    model: Model, current: Explanation, best: Step, tried: Sequence[Step], progress: Progress
) -> tuple[Step, tuple[Step, ...], Step | None]:
    """``best``, or the hypothesis that is far likelier and that free runs refuse, fitted from the model as given, where
    that is better; all that were tried, with it; and the one that was refused all the same.

    A fit that began astray is bent elsewhere: free runs then tell of that and not of the hypothesis, and what is taken
    in its place makes up for it. What is asked next (play) is asked in vain where this tells all.
    """
    likeliest = _refused(model, current, best, tried)
    if likeliest is None:
        return best, tuple(tried), None
    if not allowed(f"whether {likeliest.score.candidate.label} was refused for something else"):
        return best, tuple(tried), None
    after = relieved(model, likeliest.after, progress)
    if after is None:
        return best, tuple(tried), likeliest
    gain, p_value = current.fit.loss - after.fit.loss, heldout_p_value(current, after)
    anew = replace(likeliest, after=after, gain=gain, p_value=p_value)
    tried = tuple(anew if each is likeliest else each for each in tried)
    if earns(model, current, after, anew.score.candidate) and improves(best.after, after):
        return anew, tried, None
    return best, tried, anew


def reconsidered(
    model: Model, current: Explanation, best: Step, tried: Sequence[Step], refused: Step | None, progress: Progress
) -> tuple[Step | None, Pair | None]:
    """What explains more than ``best`` where a hypothesis is far likelier, and free runs refuse it: it with a second
    effect beside it, or, if it is not the one that was ``refused`` already, fitted from the model as given; else
    ``best``. A fit beside which something is missing is bent elsewhere, too.
    """
    likeliest = _refused(model, current, best, tried)
    if likeliest is None:
        return best, None
    if likeliest is not refused:
        best, _, refused = fitted_anew(model, current, best, tried, progress)
    if refused is None:
        return best, None
    pair = both(model, current, (refused,), progress)
    if pair is None or pair[1].after.fit.loss > best.after.fit.loss or not improves(best.after, pair[1].after):
        return best, None
    return None, pair


def _refused(model: Model, current: Explanation, best: Step, tried: Sequence[Step]) -> Step | None:
    """The likeliest hypothesis, where it is far likelier than ``best``, and sure."""
    likeliest = max(tried, key=lambda each: worth(model, each))
    if worth(model, best) >= LIKELY * worth(model, likeliest) or not _sure(model, current, likeliest):
        return None
    return likeliest


def _sure(model: Model, current: Explanation, of: Step) -> bool:
    """Whether a hypothesis raises the likelihood beyond doubt, on held-out data too, and its size is certain."""
    return (
        worth(model, of) > WORTH
        and certain(model, of.after, of.score.candidate)
        and likelihood_p_value(current, of.after) < LEVEL
    )
