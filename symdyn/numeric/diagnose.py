"""The loop that closes: residual -> hypotheses -> fit -> held-out judgement -> a new specification."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]

from symdyn.base.errors import InputError, NumericalError
from symdyn.numeric.candidates import Candidate
from symdyn.numeric.conclude import conclude, specification
from symdyn.numeric.evidence import gaussian_gain
from symdyn.numeric.excitation import unexcited
from symdyn.numeric.explanation import LEVEL, Case, Explanation, heldout_gain, ready
from symdyn.numeric.filtering.diagnose import diagnose_hidden
from symdyn.numeric.filtering.needed import has_hidden_parts
from symdyn.numeric.findings import Alternative, Diagnosis, Finding, Rival
from symdyn.numeric.groups import rigid_group
from symdyn.numeric.noise_floor import independent_samples
from symdyn.numeric.recording import Recording
from symdyn.numeric.regression import encompassing
from symdyn.numeric.runs import Runs, training_and_heldout
from symdyn.numeric.search import TIE, Search, Trial, rank
from symdyn.numeric.setting import Setting, prepare
from symdyn.numeric.skew import check_skew, skew_left
from symdyn.spec.records import Robot

Progress = Callable[[str], None]

MAX_FINDINGS = 6  # per joint
WIDER = 1.5  # times the band, from which on it is worth another search
ALTERNATIVES = 3  # shown per step


def diagnose(
    robot: Robot,
    training: Runs,
    heldout: Runs | None = None,
    *,
    band: float | None = None,
    progress: Progress = lambda _: None,
) -> Diagnosis:
    """Explain what the model lacks.

    Effects are chosen on ``training`` alone, by blocked cross-validation; ``heldout`` judges each
    one. Either is a recording or several; without ``heldout``, blocks of the training recordings judge
    (``runs.split``). ``band`` in Hz fixes the analysis band (None: found from the residual).

    Raises InputError when the recordings do not measure what the model's equations need, or do not go
    together; BadRecording when their mismatch is that of a recording, not of a machine; NumericalError
    when the model as given cannot be fitted.
    """
    fitted, judge = training_and_heldout(training, heldout)
    with threadpool_limits(1):  # the matrices are tall and narrow: threads would only wait for each other
        if has_hidden_parts(robot, fitted):
            return diagnose_hidden(robot, fitted, judge, progress)
        return _diagnose(robot, fitted, judge, band, progress)


def _diagnose(
    robot: Robot, training: Recording, heldout: Recording, band: float | None, progress: Progress
) -> Diagnosis:
    setting = prepare(robot, training, heldout, progress)
    case = setting.case(setting.given() if band is None else band)
    given = current = case.explain()
    findings: list[Finding] = []
    alarms: list[str] = []
    current, findings = _forward(case, current, findings, setting.proposed, alarms, progress)
    if band is None:
        case, given, current, findings = _widened(setting, case, given, current, findings, alarms, progress)
    current, findings = _reexamined(case, current, findings, alarms)
    case, current, findings = _physical(case, current, findings, alarms)
    skew = check_skew(case, given, current)
    alarms += unexcited(case.bench, given.fit.p, given.fit.names, given.training, given.weight)
    findings = [_with_rivals(case, current, finding, setting.proposed, progress) for finding in findings]
    return conclude(case, given, current, findings, alarms, training.name, heldout.name, skew)


def _forward(
    case: Case,
    current: Explanation,
    findings: list[Finding],
    proposed: Sequence[Candidate],
    alarms: list[str],
    progress: Progress,
) -> tuple[Explanation, list[Finding]]:
    """Effect after effect, until none earns its place any more."""
    findings = list(findings)
    while len(findings) < MAX_FINDINGS * len(case.joints):
        earning, refused = _tried(case, current, proposed, f"step {len(findings) + 1}", progress)
        alarms += [f"{t.candidate.label} would fit only with a value outside its bounds" for t in refused]
        step = _first_that_earns(case, current, earning, alarms)
        if step is None:
            break
        trial, better = step
        findings.append(_finding(case, trial.candidate, current, better, _alternatives(case, current, earning, trial)))
        current = better
        progress(f"found: {findings[-1].title} at {findings[-1].place}")
    return current, findings


def _widened(
    setting: Setting,
    case: Case,
    given: Explanation,
    current: Explanation,
    findings: list[Finding],
    alarms: list[str],
    progress: Progress,
) -> tuple[Case, Explanation, Explanation, list[Finding]]:
    """What was found filled the band. What it covered may be quicker: the search goes on in the band of what is left.

    Where that finds nothing, or no effort was measured that could be quicker than the motion, everything stays as
    it was in the narrow band, which holds less noise. So it does where efforts are late: every jump leaves something
    quick then, and a friction that remembers would be named for it.
    """
    if not np.any(case.bench.effort):
        return case, given, current, findings
    cutoff = setting.left(current)
    if not findings or cutoff < WIDER * case.bench.edge or skew_left(case, current) is not None:
        return case, given, current, findings
    progress(f"what is left reaches up to {cutoff:.3g} Hz")
    wide = setting.case(cutoff, case.bench.edge)
    before = wide.explain(current.found, current)
    noted: list[str] = []
    after, more = _forward(wide, before, findings, setting.proposed, noted, progress)
    if len(more) == len(findings):
        return case, given, current, findings
    alarms += noted
    return wide, wide.explain(), after, more


def _physical(
    case: Case, current: Explanation, findings: list[Finding], alarms: list[str]
) -> tuple[Case, Explanation, list[Finding]]:
    """Parameters that no machine can have are drawn towards the given ones until one can."""
    for share in (1.0, 0.3, 0.1, 0.03):
        try:
            specification(case, current)
            break
        except InputError as error:
            alarms.append(f"no machine has the parameters that fit best: {error.problems[0].message}")
            case = replace(case, spread=share * case.spread)
            current = case.explain(current.found, current)
    return case, current, _updated(case, current, findings)


def _updated(case: Case, current: Explanation, findings: Sequence[Finding]) -> list[Finding]:
    """Those of the findings that are still held, with their final values."""
    kept = {(c.effect, c.place.address): c for c, _ in current.found}
    return [
        replace(f, parameters=case.parameters(kept[f.effect, f.place], current))
        for f in findings
        if (f.effect, f.place) in kept
    ]


def _tried(
    case: Case, current: Explanation, proposed: Sequence[Candidate], step: str, progress: Progress
) -> tuple[list[Trial], list[Trial]]:
    search = Search(case.laws, current.training, current.design, current.weight)
    open_ = ready(proposed, case.robot, current.effects)
    return rank(search, open_, LEVEL, lambda what: progress(f"{step}: {what}"))


def _first_that_earns(
    case: Case, current: Explanation, earning: Sequence[Trial], alarms: list[str]
) -> tuple[Trial, Explanation] | None:
    """The best candidate on training data that held-out data confirm, fitted."""
    for trial in earning:
        try:
            better = case.explain((*current.found, (trial.candidate, trial.shapes)), current)
        except NumericalError:
            alarms.append(f"{trial.candidate.label} could not be fitted: it does not settle")
            continue
        if not case.certain(trial.candidate, better):
            alarms.append(f"{trial.candidate.label} lowers the error, but its size cannot be told from zero")
            continue
        if case.earns(current, better):
            return trial, better
        alarms.append(f"{trial.candidate.label} fits the training data better, but not the held-out data")
    return None


def _alternatives(case: Case, current: Explanation, earning: Sequence[Trial], chosen: Trial) -> tuple[Alternative, ...]:
    """What else would have earned this step, and the held-out error it would have left."""
    found = []
    for trial in [t for t in earning if t is not chosen][:ALTERNATIVES]:
        try:
            other = case.explain((*current.found, (trial.candidate, trial.shapes)), current)
        except NumericalError:
            continue
        error = case.errors(other).heldout
        found.append(Alternative(trial.candidate.effect, trial.candidate.place.address, error))
    return tuple(found)


def _finding(
    case: Case,
    candidate: Candidate,
    before: Explanation,
    after: Explanation,
    alternatives: tuple[Alternative, ...],
) -> Finding:
    return Finding(
        candidate.effect,
        candidate.title,
        candidate.place.address,
        case.parameters(candidate, after),
        case.errors(before).heldout,
        case.errors(after).heldout,
        heldout_gain(before, after)[1],
        (),
        alternatives,
        rigid_group(case.robot.joints[case.joints.index(candidate.place.address)], candidate.effect),
        gaussian_gain(before.heldout, after.heldout, independent_samples(case.judge)),
    )


def _reexamined(
    case: Case, current: Explanation, findings: list[Finding], alarms: list[str]
) -> tuple[Explanation, list[Finding]]:
    """Earlier findings that later ones made needless are taken out again; the rest get their final values."""
    for item in current.found[:-1]:
        candidate, _ = item
        corrected = any(c.builds_on == candidate.effect and c.place == candidate.place for c, _ in current.found)
        if corrected and case.certain(candidate, current):
            continue
        without = case.explain(tuple(other for other in current.found if other is not item), current)
        if not case.earns(without, current):
            alarms.append(f"{candidate.label} was taken out again: later findings explain it better")
            current = without
    return current, _updated(case, current, findings)


def _with_rivals(
    case: Case, current: Explanation, finding: Finding, proposed: Sequence[Candidate], progress: Progress
) -> Finding:
    """What it does not improve on beyond chance: other effects at its place (rivals), itself elsewhere (group)."""
    progress(f"looking for rivals of {finding.title} at {finding.place}")
    mine = next(i for i in current.found if (i[0].effect, i[0].place.address) == (finding.effect, finding.place))
    rest = case.explain(tuple(item for item in current.found if item is not mine), current)
    search = Search(case.laws, rest.training, rest.design, rest.weight)
    own = search.trial(mine[0])
    rivals, group = [], list(finding.group)
    for other in ready(proposed, case.robot, rest.effects):
        if other is mine[0] or (other.place != mine[0].place and other.effect != mine[0].effect):
            continue
        trial = search.trial(other)
        if search.contains(trial, own):
            continue  # the finding and more: it fits as well by being the same
        p_value = encompassing(trial.errors, own.errors)[1]
        if trial.admissible and trial.gain > 0 and p_value > TIE:
            if other.place == mine[0].place:
                rivals.append(Rival(other.effect, other.place.address, p_value))
            else:
                group.append(other.place.address)
    return replace(finding, rivals=tuple(rivals), group=tuple(group))
