"""A law with memory that contains one that was found, in its place: the latter was chosen when more was missing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from symdyn.numeric.filtering.budget import allowed
from symdyn.numeric.filtering.judged import LIKELY, Explanation, Step, certain, improves, price, worth
from symdyn.numeric.filtering.memory_fits import SIMPLEST, with_every_hypothesis, with_wider_law
from symdyn.numeric.filtering.model import Model
from symdyn.numeric.filtering.remembering import needed
from symdyn.numeric.filtering.telling import finding
from symdyn.numeric.findings import Finding
from symdyn.numeric.recording import Recording

Progress = Callable[[str], None]


def widened(
    model: Model,
    current: Explanation,
    best: Step | None,
    findings: Sequence[Finding],
    recordings: tuple[Recording, Recording],
    progress: Progress,
) -> tuple[Model, Explanation, list[Finding]] | None:
    """The machine with a wider law, where that explains more than ``best`` beside the simplest; None where none does.

    Asked of what something was found after: until then, all laws were asked. Of two as good on held-out data the
    simplest was taken, beside which what was missing then was as large.
    """
    least = needed(model, best)
    for simplest, _ in current.found[:-1]:
        at = simplest.place.address
        if simplest.effect != SIMPLEST or not allowed(f"a wider law in the place of {simplest.label}"):
            continue
        had = price(model, simplest)
        tried = with_wider_law(model, current, simplest, LIKELY * least - had, recordings, progress)
        good = [
            (own, law)
            for own, law in tried
            if worth(own, law) + had > least
            and improves(current, law.after, law.p_value)
            and certain(own, law.after, law.score.candidate)
        ]
        if good:
            own, chosen = good[0]
            whole, after = with_every_hypothesis(model, chosen, recordings, progress)
            told = finding(own, current, chosen, tuple(law for _, law in tried))
            return whole, after, [_instead(f, told) if (f.effect, f.place) == (SIMPLEST, at) else f for f in findings]
    return None


def _instead(simplest: Finding, told: Finding) -> Finding:
    """What the wider law tells, of all that the two tell."""
    evidence = simplest.evidence + told.evidence
    return replace(told, heldout_before=simplest.heldout_before, group=simplest.group, evidence=evidence)
