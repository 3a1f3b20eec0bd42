"""Laws that contain one another: the wider one where it earns it, the simpler one where that does as well."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import NumericalError
from symdyn.numeric.candidates import Candidate
from symdyn.numeric.explanation import Explanation
from symdyn.numeric.forward import first_that_earns
from symdyn.numeric.inquiry import Inquiry, finding_of
from symdyn.numeric.kinship import akin
from symdyn.numeric.regression import likelier
from symdyn.numeric.search import EARNS, Search, Trial
from symdyn.numeric.skew import certain, effort_skew
from symdyn.physics import catalogue

Array = NDArray[np.float64]
Progress = Callable[[str], None]

PROMISES = 0.5  # of what must be earned: what takes less off the training error, to first order, is not fitted in full


def generalised(inquiry: Inquiry, places: Collection[str], progress: Progress) -> tuple[Inquiry, bool]:
    """A law akin to what was found at its place takes that place where it earns it; and whether any did.

    Asked at ``places``. Step by step the nearest simple law comes first, and what it lacks is no law of its own: Dahl's
    of LuGre's, say.
    """
    swapped = False
    known: dict[tuple[str, ...], tuple[Explanation, Search, Array]] = {}  # without these: several laws ask for it
    for wider in (c for c in inquiry.setting.proposed if c.place.address in places):
        less = [i for i in inquiry.current.found if i[0].place == wider.place and akin(i[0].effect, wider.effect)]
        less = [i for i in less if wider.effect not in catalogue()[i[0].effect].generalises]
        if not less or wider.key in inquiry.current.effects:
            continue
        progress(f"instead of {less[0][0].label}: {wider.title}")
        gone = [c for c, _ in less]
        labels = tuple(c.label for c in gone)
        if labels not in known:
            without = explained_without(inquiry, gone)
            stands = search_beside(inquiry, replace(inquiry.current, weight=without.weight)).errors
            known[labels] = without, search_beside(inquiry, without), stands
        rest, search, stands = known[labels]
        trial = _tried(search, wider)
        step = first_that_earns(inquiry, [trial], rest)[0] if _promises(trial, stands) else None
        if step is not None:
            inquiry, swapped, known = exchanged(inquiry, gone, rest, step[1]), True, {}
            names = ", ".join(c.title for c in gone)
            inquiry = inquiry.noting(f"{wider.label} took the place of {names}, which it is akin to, and better")
    return inquiry, swapped


def _promises(trial: Trial, stands: Array) -> bool:
    """Whether it takes enough off the errors ``stands`` (K, n) of what it would replace to be fitted in full."""
    before, after = (np.sqrt(np.mean(errors**2, axis=0)) for errors in (stands, trial.errors))
    return trial.admissible and bool(np.any(after <= (1.0 - PROMISES * EARNS) * before))


def simplified(inquiry: Inquiry, progress: Progress) -> Inquiry:
    """What was found early may be wider than needed, or not needed, now that all the rest is known."""
    for candidate, _ in inquiry.current.found:
        for simpler in _simpler(inquiry, candidate):
            progress(f"instead of {candidate.label}: {', '.join(c.title for c in simpler)}")
            rest = explained_without(inquiry, [candidate])
            try:
                after = _with(inquiry, rest, simpler)
            except NumericalError:
                continue
            if after is not None and not _earns(inquiry, after, rest):
                names = ", ".join(c.title for c in simpler)
                told = f"{candidate.label} contains {names}, which explains as much by itself"
                if not inquiry.case.earns(rest, after):
                    after, told = rest, f"{candidate.label} was taken out again: later findings explain it better"
                inquiry = exchanged(inquiry, [candidate], rest, after).noting(told)
                break
    return inquiry


def _earns(inquiry: Inquiry, simpler: Explanation, rest: Explanation) -> bool:
    """Whether the wider law explains more than the simpler one, also if the efforts were late against the motion.

    After every jump late efforts look like friction that remembers. ``rest`` has neither law.
    """
    case, wider = inquiry.case, inquiry.current
    late = effort_skew(case, simpler)
    if certain(case, late) and likelier(late.heldout, wider.heldout * simpler.weight)[0] < 0.0:
        return False
    return case.earns(simpler, wider, bare=rest)


def _simpler(inquiry: Inquiry, wider: Candidate) -> list[list[Candidate]]:
    """Laws that it contains, the fewest numbers first; what corrects another comes with that."""
    contained = catalogue()[wider.effect].generalises
    here = [c for c in inquiry.setting.proposed if c.place == wider.place and c.effect in contained]
    found = []
    for candidate in here:
        base = [c for c in here if c.effect == candidate.builds_on]
        if candidate.builds_on is None or base:
            found.append([*base, candidate])
    return sorted(found, key=lambda group: sum(c.size for c in group))


def _with(inquiry: Inquiry, rest: Explanation, added: Sequence[Candidate]) -> Explanation | None:
    """Fitted one after the other; None where one is outside its bounds."""
    for candidate in added:
        trial = _tried(search_beside(inquiry, rest), candidate)
        if not trial.admissible:
            return None
        rest = inquiry.case.explain((*rest.found, (candidate, trial.shapes)), rest)
    return rest


def search_beside(inquiry: Inquiry, rest: Explanation) -> Search:
    """For what explains the case on top of ``rest``."""
    return Search(inquiry.case.laws, rest.fit.p, rest.training, rest.design, rest.weight)


def _tried(search: Search, candidate: Candidate) -> Trial:
    trial = search.trial(candidate)
    return search.polished(trial) if len(candidate.shapes) > 1 else trial


def explained_without(inquiry: Inquiry, gone: Sequence[Candidate]) -> Explanation:
    """What explains the case without some of what was found."""
    found = tuple(item for item in inquiry.current.found if not any(item[0] is c for c in gone))
    return inquiry.case.explain(found, inquiry.current)


def exchanged(inquiry: Inquiry, gone: Sequence[Candidate], rest: Explanation, after: Explanation) -> Inquiry:
    """With ``after`` in place of what is ``gone``; ``rest`` is what both have."""
    keys = {c.key for c in gone}
    kept = [f for f in inquiry.findings if f.key not in keys]
    new = [c for c, _ in after.found if c.key not in rest.effects]
    found = [finding_of(inquiry.case, c, rest, after) for c in new]
    return replace(inquiry, current=after, findings=tuple(chain(kept, found)))
