"""Forward selection: one missing effect after the other, chosen on training data, confirmed on held-out data."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import NumericalError
from symdyn.numeric.candidates import Candidate
from symdyn.numeric.explanation import LEVEL, Case, Explanation, Revised
from symdyn.numeric.findings import Alternative, Rival
from symdyn.numeric.inquiry import Inquiry, finding_of, finding_of_revision
from symdyn.numeric.kinship import ready, waiting
from symdyn.numeric.noise_floor import independent_samples
from symdyn.numeric.regression import likelier, log_loss
from symdyn.numeric.revision import Revision
from symdyn.numeric.search import TIE, Search, Trial, rank
from symdyn.numeric.together import pair_that_earns

Array = NDArray[np.float64]
Progress = Callable[[str], None]

MAX_FINDINGS = 6  # per joint
ALTERNATIVES = 3  # shown per step
BEST = 3  # revisions that are fitted at a step
HALF = 0.5  # of what the best effect takes off the loss


@dataclass(frozen=True, slots=True, eq=False)
class RevisionTrial:
    """A revision, tried to first order: which of its values, and the error that it would leave."""

    revision: Revision
    tried: int
    tests: int
    size: int  # how many numbers it brings
    errors: Array  # (K, n)
    p_value: float  # of "no gain"
    matches: float  # of "the best effect explains no more"

    @property
    def loss(self) -> float:
        return log_loss(self.errors)


def forward(inquiry: Inquiry, open_: Sequence[Revision], progress: Progress) -> Inquiry:
    """Effect after effect, until none earns its place any more; ``open_`` revisions compete with them."""
    adopted: list[Revision] = []
    promised: dict[str, float] = {}  # by revisions that were refused, when they were
    while len(inquiry.findings) < MAX_FINDINGS * len(inquiry.case.joints):
        case, current = inquiry.case, inquiry.current
        if case.nothing_left(current):
            return inquiry
        search = Search(case.laws, current.fit.p, current.training, current.design, current.weight)
        proposed = ready(inquiry.setting.proposed, case.robot, current.effects)
        earning, refused = rank(search, proposed, LEVEL, _counted(progress, len(inquiry.findings) + 1))
        inquiry = inquiry.noting(*(outside_bounds(t) for t in refused))
        step, refusals = first_that_earns(inquiry, earning)
        best = sorted(earning, key=lambda t: t.loss)[:1] if step is not None else []
        revised = _revised(inquiry, search, open_, best, step, promised, progress)
        if revised is not None:
            inquiry, open_ = revised[0], [r for r in open_ if r is not revised[1]]
            adopted.append(revised[1])
        elif step is None and (both := pair_that_earns(inquiry, search, proposed)) is not None:
            pair, better = both
            found = tuple(finding_of(case, candidate, current, better) for candidate in pair)
            inquiry = _refitted(replace(inquiry, current=better, findings=(*inquiry.findings, *found)), adopted)
        else:
            if step is None:
                shut = waiting(inquiry.setting.proposed, case.robot, current.effects)
                earning, _ = rank(search, shut, LEVEL, progress)
                step, _ = first_that_earns(inquiry, earning)
            if step is None:
                return inquiry.noting(*refusals)
            trial, better = step
            others = _alternatives(inquiry, earning, trial)
            finding = finding_of(case, trial.candidate, current, better, others)
            inquiry = replace(inquiry, current=better, findings=(*inquiry.findings, finding)).noting(*refusals)
            inquiry = _refitted(inquiry, adopted)
        progress(f"found: {inquiry.findings[-1].title} at {inquiry.findings[-1].place}")
    return inquiry


def _refitted(inquiry: Inquiry, adopted: Sequence[Revision]) -> Inquiry:
    """What sensors were found to show was fitted before the last effect was known, and took up some of it."""
    for revision in adopted:
        try:
            after = revision.refitted(inquiry)
        except NumericalError:
            continue
        if after is not None and log_loss(after.current.training) < log_loss(inquiry.current.training):
            inquiry = after
    return inquiry


def first_that_earns(
    inquiry: Inquiry, earning: Sequence[Trial], base: Explanation | None = None
) -> tuple[tuple[Trial, Explanation] | None, list[str]]:
    """The best candidate that held-out data confirm, fitted on top of ``base`` (or what stands), and the refusals."""
    case, current, refusals = inquiry.case, inquiry.current, []
    below = current if base is None else base
    for trial in earning:
        label = trial.candidate.label
        try:
            better = case.explain((*below.found, (trial.candidate, trial.shapes)), below)
        except NumericalError:
            refusals.append(f"{label} could not be fitted: it does not settle")
            continue
        if case.bounded(trial.candidate, better):
            refusals.append(outside_bounds(trial))
        elif not case.certain(trial.candidate, better):
            refusals.append(f"{label} lowers the error, but its size cannot be told from zero")
        elif not case.apart(trial.candidate, better):
            refusals.append(f"{label} may be the one that was found, where its size is not the same everywhere")
        elif case.confirms(trial.candidate, current, better, base):
            return (trial, better), refusals
        else:
            refusals.append(f"{label} fits the training data better, but not the held-out data")
    return None, refusals


def outside_bounds(trial: Trial) -> str:
    """What is told of a law that fits as another one: friction that drives, a gear that passes nothing on."""
    return f"{trial.candidate.label} would fit only with a value outside its bounds"


def _counted(progress: Progress, step: int) -> Progress:
    return lambda what: progress(f"step {step}: {what}")


def _alternatives(inquiry: Inquiry, earning: Sequence[Trial], chosen: Trial) -> tuple[Alternative, ...]:
    """What else would have earned this step, and the held-out error it would have left."""
    case, current, found = inquiry.case, inquiry.current, []
    best = {(t.candidate.effect, t.candidate.place): t for t in (*reversed(earning), chosen)}  # of each effect, one
    for trial in [t for t in earning if t in best.values() and t is not chosen][:ALTERNATIVES]:
        try:
            other = case.one_fit((*current.found, (trial.candidate, trial.shapes)), current)
        except NumericalError:
            continue
        found.append(Alternative(trial.candidate.effect, trial.candidate.place.address, case.errors(other).heldout))
    return tuple(found)


def tried_revisions(
    inquiry: Inquiry, search: Search, open_: Sequence[Revision], best: Sequence[Trial], progress: Progress
) -> list[RevisionTrial]:
    """Every revision at the best of its values."""
    found = []
    for revision in open_:
        progress(revision.label)
        columns = revision.columns(inquiry)
        errors = [search.errors_with(each) for each in columns]
        losses = [log_loss(e) for e in errors]
        at = min(range(len(errors)), key=losses.__getitem__)
        gain, p_value = likelier(search.errors, errors[at])
        p_value, matches = (p_value, 1.0) if gain > 0 else (1.0, 0.0)
        if best and gain > 0:
            matches = min(likelier(errors[at], t.errors)[1] for t in best)
        found.append(RevisionTrial(revision, at, len(errors), columns[at].shape[2], errors[at], p_value, matches))
    return found


def _revised(
    inquiry: Inquiry,
    search: Search,
    open_: Sequence[Revision],
    best: Sequence[Trial],
    effect: tuple[Trial, Explanation] | None,
    promised: dict[str, float],
    progress: Progress,
) -> tuple[Inquiry, Revision] | None:
    """The revision that explains more than chance, and more than the best ``effect``, confirmed on held-out data.

    To first order a revision is judged too harshly: what takes half as much off the error as the best effect does
    is fitted, and then compared. What was refused is fitted again once it promises more than it ``promised`` then.
    """
    trials = tried_revisions(inquiry, search, open_, best, progress)
    tests = sum(trial.tests for trial in trials)
    stands = log_loss(search.errors)
    least = HALF * max((stands - trial.loss for trial in best), default=0.0)
    falls = {t.revision.label: stands - t.loss for t in trials}
    earning = [t for t in trials if t.p_value * tests < LEVEL and falls[t.revision.label] > least]
    earning = [t for t in earning if falls[t.revision.label] > promised.get(t.revision.label, 0.0)]
    fitted: list[tuple[RevisionTrial, Inquiry]] = []
    for trial in sorted(earning, key=lambda t: t.loss)[:BEST]:
        try:
            after = trial.revision.revised(inquiry, trial.tried)
        except NumericalError:
            after = None
        if after is None or not after.case.earns(inquiry.current, after.current, _new(trial.revision, after).sensor):
            promised[trial.revision.label] = falls[trial.revision.label]
            continue
        if effect is None or explains_more(inquiry.case, effect[0].candidate, effect[1], after.current, trial.size):
            fitted.append((trial, after))
    if not fitted:
        return None
    trial, after, rivals = _simplest(fitted)
    new = finding_of_revision(after.case, _new(trial.revision, after), inquiry.current, after.current)
    finding = replace(new, rivals=rivals)
    others = tuple(f for f in after.findings if (f.effect, f.place) != trial.revision.key)
    return replace(after, findings=(*others, finding)), trial.revision


def _new(revision: Revision, after: Inquiry) -> Revised:
    return next(r for r in after.case.revised if (r.effect, r.place) == revision.key)


def _simplest(fitted: Sequence[tuple[RevisionTrial, Inquiry]]) -> tuple[RevisionTrial, Inquiry, tuple[Rival, ...]]:
    """The likeliest, or what it cannot be told from, or is not worth its numbers beside, and brings fewer of them; the
    others of those are rivals.

    On a flat arm an encoder that is off at the first joint, and a base that is tilted, are the same.
    """
    wide, likeliest = min(fitted, key=lambda item: log_loss(item[1].current.training))
    best, tied = likeliest.current.training, []
    for trial, after in fitted:
        gain, p_value = likelier(after.current.training, best) if after is not likeliest else (0.0, 1.0)
        if p_value > TIE or not _worth(likeliest.case, gain, wide.size - trial.size):
            tied.append((trial, after, p_value))
    tied.sort(key=lambda item: (item[0].size, log_loss(item[1].current.training)))
    chosen, after, _ = tied[0]
    return chosen, after, tuple(Rival(*trial.revision.key, p) for trial, _, p in tied[1:])


def explains_more(case: Case, effect: Candidate, explained: Explanation, revised: Explanation, size: int) -> bool:
    """Whether a revision with ``size`` numbers does, beyond chance, on the data that both were fitted to.

    Each number that it has more than the effect must be worth log(N) (Schwarz): the weight of a single vertical axis is
    gravity's, or a constant force, and one number tells it as well as three.
    """
    gain, p_value = likelier(explained.training, revised.training)
    lower = log_loss(revised.training) < log_loss(explained.training)
    return _worth(case, gain, size - effect.size) and gain > 0.0 and p_value < LEVEL and lower


def _worth(case: Case, gain: float, numbers: int) -> bool:
    """Whether a gain of the log-likelihood (per sample, doubled) is worth so many numbers more (Schwarz)."""
    count = independent_samples(case.bench)
    return bool(gain * count >= numbers * np.log(count))
