"""What was found, examined once more: all of it together, and whether a machine may have such numbers."""

from __future__ import annotations

from dataclasses import replace

from symdyn.base.errors import InputError
from symdyn.numeric.candidates import Candidate
from symdyn.numeric.conclude import specification
from symdyn.numeric.explanation import Case, Explanation
from symdyn.numeric.freed import numbers_of
from symdyn.numeric.inquiry import Inquiry, estimates
from symdyn.numeric.revision import without
from symdyn.numeric.rounding import RESOLUTION


def proved(inquiry: Inquiry) -> Inquiry:
    """What was found is examined once more, all of it together, and so is whether a machine may have such numbers."""
    inquiry = _physical(_reexamined(inquiry))
    for revised in inquiry.setting.revised:
        numbers = estimates(inquiry.case, revised, inquiry.current)
        if revised.names and not numbers_of(revised.effect, revised.place).credible(numbers):
            told = f"{revised.title} at {revised.place} was taken out again: beside the rest no machine has its numbers"
            return proved(without(inquiry, revised).noting(told))
    return inquiry


def _physical(inquiry: Inquiry) -> Inquiry:
    """Parameters that no machine can have are drawn towards the given ones until one can."""
    case, current = inquiry.case, inquiry.current
    for share in (1.0, 0.3, 0.1, 0.03):
        try:
            specification(case, current, inquiry.setting.part)
            break
        except InputError as error:
            inquiry = inquiry.noting(f"no machine has the parameters that fit best: {error.problems[0].message}")
            case = replace(case, spread=share * case.spread)
            current = case.explain(current.found, current)
    return replace(inquiry, case=case, current=current).settled()


def _reexamined(inquiry: Inquiry) -> Inquiry:
    """Earlier findings that later ones made needless are taken out again; the rest get their final values."""
    found = inquiry.current.found
    shown_otherwise = inquiry.setting.revised or inquiry.setting.readings != inquiry.origin.readings
    for item in found if shown_otherwise else found[:-1]:  # the last one has just earned its place
        case, current, candidate = inquiry.case, inquiry.current, item[0]
        if _corrected(candidate, current) and case.certain(candidate, current):
            continue
        less = _less(case, current, candidate)
        if not case.confirms(candidate, less, current):
            told = f"{candidate.label} was taken out again: later findings explain it better"
            inquiry = replace(inquiry, current=less).noting(told)
    since = found or inquiry.setting.readings[0].late  # what the last one did not know
    for revised in inquiry.setting.revised[: None if since else -1]:
        if set(revised.values) == {RESOLUTION}:  # nothing that a fit holds: known in size, not in course
            continue
        bare = without(inquiry, revised)
        if not inquiry.case.earns(bare.current, inquiry.current, revised.sensor):
            inquiry = bare.noting(f"{revised.title} at {revised.place} was taken out again: the rest explains it")
    return inquiry.settled()


def sized(inquiry: Inquiry) -> Inquiry:
    """Without what has no size in intervals as they are now, as it would have been refused: the latest first."""
    for candidate, _ in reversed(inquiry.current.found):
        case, current = inquiry.case, inquiry.current
        if not _corrected(candidate, current) and not case.certain(candidate, current):
            told = f"{candidate.label} was taken out again: beside noise of positions its size cannot be told from zero"
            inquiry = replace(inquiry, current=_less(case, current, candidate)).settled().noting(told)
    return inquiry


def _corrected(candidate: Candidate, of: Explanation) -> bool:
    """Whether another finding is a correction of it."""
    return any(c.builds_on == candidate.effect and c.place == candidate.place for c, _ in of.found)


def _less(case: Case, of: Explanation, candidate: Candidate) -> Explanation:
    """All but that one."""
    return case.explain(tuple(other for other in of.found if other[0] is not candidate), of)
