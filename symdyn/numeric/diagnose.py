"""The loop that closes: residual -> hypotheses -> fit -> held-out judgement -> a new specification."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from symdyn.numeric.candidates import Candidate, fitted_parameters, held_parameters
from symdyn.numeric.circuits import driven_by_current
from symdyn.numeric.conclude import conclude
from symdyn.numeric.confused import check_confused
from symdyn.numeric.cut import Part
from symdyn.numeric.excitation import unexcited
from symdyn.numeric.explanation import LEVEL
from symdyn.numeric.few_waves import waves_instead
from symdyn.numeric.filtering.needed import can_follow, has_hidden_parts
from symdyn.numeric.findings import Diagnosis
from symdyn.numeric.forward import first_that_earns, forward
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.kinship import ready
from symdyn.numeric.known import known_names
from symdyn.numeric.leftover import SHARE, slow_share
from symdyn.numeric.mechanics import mechanics, untested
from symdyn.numeric.mere_filter import merely_filters, without_swinging
from symdyn.numeric.nested import generalised, simplified
from symdyn.numeric.observation import untested_equations
from symdyn.numeric.other_words import in_other_words
from symdyn.numeric.proof import proved, sized
from symdyn.numeric.recording import Recording
from symdyn.numeric.rest import often_stands
from symdyn.numeric.revision import Revision, revisions
from symdyn.numeric.rivals import with_rivals
from symdyn.numeric.rounding import below_steps, ended_at_steps, with_resolutions
from symdyn.numeric.runs import Runs, doubts, training_and_heldout
from symdyn.numeric.search import EARNS, Search, rank
from symdyn.numeric.servo_loops import as_driven, loops_left_out
from symdyn.numeric.setting import prepare
from symdyn.numeric.simple_pair import pairs_instead
from symdyn.numeric.skew import (
    HALF,
    a_little_late,
    aligned,
    check_skew,
    earlier,
    effort_skew,
    held,
    skew_left,
    tells_nearly_all,
    with_skew,
)
from symdyn.numeric.too_quick import too_quick
from symdyn.numeric.torque_sensors import parts
from symdyn.numeric.trembling import with_trembling
from symdyn.numeric.united import united
from symdyn.spec.effect_schema import Scan
from symdyn.spec.records import Robot

Progress = Callable[[str], None]

FEW = 3  # effects that a delay is compared with
QUICK = frozenset({Scan.ANGLE_ORDER, Scan.SPEED, Scan.DISPLACEMENT})  # of laws that may be quicker than a motion
WIDER = 1.5  # times the band, from which on it is worth another search


def diagnose(
    robot: Robot,
    training: Runs,
    heldout: Runs | None = None,
    *,
    band: float | None = None,
    hold: Sequence[str] = (),
    thorough: bool = False,
    progress: Progress = lambda _: None,
) -> Diagnosis:
    """Explain what the model lacks.

    Effects are chosen on ``training`` alone, by blocked cross-validation; ``heldout`` judges each
    one. Either is a recording or several; without ``heldout``, blocks of the training recordings judge
    (``runs.split``). ``band`` in Hz fixes the analysis band (None: found from the residual). Parameters whose
    names fit one of the patterns ``hold`` are not fitted (``"*"``: none is); the model is right about them.
    A search with a filter that takes long ends early, and an alarm says what it did not ask, unless ``thorough``.
    Where torque sensors cut the machine (``torque_sensors.parts``), each part is diagnosed by itself.

    Raises InputError when the recordings do not measure what the model's equations need, or do not go
    together; BadRecording when their mismatch is that of a recording, not of a machine; NumericalError
    when the model as given cannot be fitted; UsageError (SD010) for a pattern that names no parameter.
    """
    runs = training_and_heldout(training, heldout)
    pieces, told = parts(robot, runs)
    found: list[Diagnosis] = []
    with threadpool_limits(1):  # the matrices are tall and narrow: threads would only wait for each other
        for part in pieces:
            whole = found[-1].diagnosed if found else robot
            seen = part.seen(whole, runs[0]), part.seen(whole, runs[1])
            found.append(_by_either_way(part, whole, seen, band, hold, thorough, _told_by(part, progress)))
    told = [*doubts(training, heldout), *told]
    return in_other_words(united(robot, pieces, found, told))


def _told_by(part: Part, progress: Progress) -> Progress:
    return lambda told: progress(part.named(told))


def _by_either_way(
    part: Part,
    whole: Robot,
    runs: tuple[Recording, Recording],
    band: float | None,
    hold: Sequence[str],
    thorough: bool,
    progress: Progress,
) -> Diagnosis:
    """By inverse dynamics, or by a filter where that sees more."""
    given = part.of(whole)
    robot = as_driven(given, runs)
    told = loops_left_out(given, robot)
    if not has_hidden_parts(robot, runs[0]):
        fixed = held_parameters(whole, fitted_parameters(whole), hold) | known_names(runs)
        begun = _begun(part, robot, runs, band, fixed, progress)
        quick = too_quick(begun.case.bench, begun.given.fit.p, begun.case.joints)
        if not quick or not begun.setting.seen.tested.all() or part.drive is not None or not can_follow(robot):
            found = _diagnose(begun.noting(*quick), band, progress)
            return replace(found, alarms=(*told, *untested(robot, mechanics(robot)), *found.alarms))
        progress("the motion is too quick for derivatives over its samples: a filter follows it")
    from symdyn.numeric.filtering.diagnose import diagnose_hidden  # compiles the filter as it is imported

    found = diagnose_hidden(robot, *runs, progress, hold, thorough)
    return replace(found, alarms=(*told, *untested(robot, driven_by_current(robot, runs)), *found.alarms))


def _begun(
    part: Part,
    robot: Robot,
    runs: tuple[Recording, Recording],
    band: float | None,
    fixed: frozenset[str],
    progress: Progress,
) -> Inquiry:
    """The model as given, fitted. Raises BadRecording where channels are confused."""
    setting = prepare(robot, *runs, progress, fixed, part)
    case = setting.case(setting.given() if band is None else band)
    given = case.explain()
    check_confused(setting, case, given)
    return Inquiry(setting, case, given, setting, case, given).noting(*untested_equations(setting.seen, setting.joints))


def _diagnose(inquiry: Inquiry, band: float | None, progress: Progress) -> Diagnosis:
    inquiry = held(inquiry)
    if band is None:
        inquiry = below_steps(inquiry)
    inquiry = _sparing(inquiry)
    open_, begun = revisions(inquiry.setting), inquiry
    _refuse_late_efforts(inquiry, progress)
    before, inquiry = _explained(begun, open_, band is None, progress)
    narrower = ended_at_steps(begun, inquiry) if band is None else None
    if narrower is not None:
        progress(f"the search begins again: {narrower.alarms[-1]}")
        begun = narrower
        before, inquiry = _explained(begun, open_, True, progress)
    if told := merely_filters(inquiry):
        progress(f"{told}; the search begins again without it")
        before, inquiry = _explained(without_swinging(begun), open_, band is None, progress)
        inquiry = replace(inquiry, setting=replace(inquiry.setting, proposed=begun.setting.proposed)).noting(told)
    bench, given = inquiry.first.bench, inquiry.given
    inquiry = inquiry.noting(*unexcited(bench, given.fit.p, given.fit.names, given.training, given.weight))
    inquiry = with_trembling(inquiry, progress)
    if (fewer := sized(inquiry)) is not inquiry:
        inquiry = with_trembling(fewer, progress)
    findings = tuple(with_rivals(inquiry, finding, open_, progress) for finding in inquiry.findings)
    inquiry = with_resolutions(with_skew(replace(inquiry, findings=findings), before))
    return conclude(inquiry, inquiry.setting.training.name, inquiry.setting.heldout.name)


def _sparing(inquiry: Inquiry) -> Inquiry:
    """Judged by what is far from standstills, where these are short, but many: they would be in nearly all samples.

    Not before it is known what the steps of encoders do: they tremble in all samples.
    """
    if not any(often_stands(each.observation, each.bring) for each in (inquiry.case.bench, inquiry.case.judge)):
        return inquiry
    setting = inquiry.setting.anew(sparing=True)
    case = setting.case(*inquiry.band)
    given = case.explain()
    return replace(inquiry, origin=setting, first=case, given=given, setting=setting, case=case, current=given)


def _explained(begun: Inquiry, open_: Sequence[Revision], widen: bool, progress: Progress) -> tuple[Inquiry, Inquiry]:
    """What was found; and before, if need be, clocks were aligned. Raises BadRecording.

    What was found beside efforts that are late by more than a sample took up some of that, and may not be there: then
    the search begins again. Beside jumps of dry friction a skew tells little of what is left, and it is right where
    nothing is left beside it. Whatever is unknown is a little like a skew, too, and goes on leaving something.
    """
    found = simplified(_searched(begun, open_, progress), progress)
    found = proved(simplified(_widened(found, progress), progress) if widen else found)
    check_skew(found.first, found.given, found.current)
    if a_little_late(found.case, found.current):
        progress("the efforts are late or early: the search goes on with the clocks aligned")
        return found, proved(aligned(proved(_searched(aligned(found), open_, progress))))
    left = skew_left(found.case, found.current)
    if left is None:
        return found, found
    progress("the efforts may be late or early: the search begins again with the clocks aligned")
    anew = earlier(begun, aligned(found).setting.readings[0].late)
    late = proved(aligned(proved(simplified(_searched(anew, open_, progress), progress))))
    return found, late if left.share > HALF or not conclude(late, "", "").remaining.structured else found


def _refuse_late_efforts(inquiry: Inquiry, progress: Progress) -> None:
    """Raise BadRecording (SD529) where one delay of all efforts tells nearly everything, and more than any effect.

    Asked before the search: effect after effect, one at each joint, would in the end do as well as the delay.
    """
    case, given = inquiry.case, inquiry.given
    if not tells_nearly_all(case, effort_skew(case, given)):
        return
    search = Search(case.laws, given.fit.p, given.training, given.design, given.weight)
    earning, _ = rank(search, ready(inquiry.setting.proposed, case.robot, given.effects), LEVEL, progress)
    step, _ = first_that_earns(inquiry, earning[:FEW])
    check_skew(case, given, given if step is None else step[1])


def _searched(inquiry: Inquiry, open_: Sequence[Revision], progress: Progress) -> Inquiry:
    """Until neither another effect, nor a wider law, a wave or two simpler laws in place of one, earns its place."""
    inquiry = forward(inquiry, open_, progress)
    places, swapped = frozenset(inquiry.case.joints), True
    while swapped:
        before = inquiry
        inquiry, widened = generalised(inquiry, places, progress)
        inquiry, waves = waves_instead(inquiry, places, progress)
        inquiry, simpler = pairs_instead(inquiry, places, progress)
        swapped = widened or waves or simpler
        if swapped:
            inquiry = forward(inquiry, open_, progress)
            places = _changed(before, inquiry)
    return inquiry


def _changed(before: Inquiry, after: Inquiry) -> frozenset[str]:
    """Joints at which other laws were found since, or less is left by what an effect must take.

    All the others said before what they have to say.
    """
    if after.case is not before.case:
        return frozenset(after.case.joints)
    swapped = {place for _, place, _ in before.current.effects ^ after.current.effects}
    sizes = [np.sqrt(np.mean(inquiry.current.training**2, axis=0)) for inquiry in (before, after)]
    less = sizes[1] <= (1.0 - EARNS) * sizes[0]
    return frozenset(j for j, fell in zip(after.case.joints, less, strict=True) if fell or j in swapped)


def _widened(inquiry: Inquiry, progress: Progress) -> Inquiry:
    """What was found filled the band. What it covered may be quicker: the search goes on in the band of what is left.

    Where that finds nothing, or no effort was measured that could be quicker than the motion, everything stays as
    it was in the narrow band, which holds less noise. So it does where efforts are late: every jump leaves something
    quick then, and a friction that remembers would be named for it. Sensors and gravity are no quick matter, and what
    swings would answer to motion that is not seen there.
    Where nothing was found in the narrow band, the wide one must show more than noise where an effort acts, and what
    may be quicker than the motion is looked for: a ripple of a high order, and what dry friction does while a joint
    hardly moves.
    """
    edge, pushed = inquiry.case.bench.edge, np.any(inquiry.case.bench.effort, axis=0)
    if not pushed.any() or _ends_at_steps(inquiry):
        return inquiry
    cutoff = inquiry.setting.left(inquiry.current)
    if cutoff < WIDER * edge or skew_left(inquiry.case, inquiry.current) is not None:
        return inquiry
    case = inquiry.setting.case(cutoff, edge)
    current = case.explain(inquiry.current.found, inquiry.current)
    if not inquiry.findings:
        share, p_value = slow_share(current.training[:, pushed], case.bench.samples_per_period)
        if share < SHARE or p_value > LEVEL:
            return inquiry
    progress(f"what is left reaches up to {cutoff:.3g} Hz")
    first = inquiry.origin.case(cutoff, edge)
    wide = replace(inquiry, first=first, given=first.explain(), case=case, current=current, motion=edge)
    quick = tuple(c for c in wide.setting.proposed if _may_be_quick(c, bool(inquiry.findings)))
    after = _searched(replace(wide, setting=replace(wide.setting, proposed=quick)), (), progress)
    if len(after.findings) > len(inquiry.findings):
        return replace(after, setting=inquiry.setting)
    if inquiry.findings:
        return inquiry
    quicker = f"what is left reaches up to {cutoff:.3g} Hz, and the motion was looked at below {edge:.3g} Hz"
    return inquiry.noting(f"{quicker}: nothing known tells what is quicker")


def _may_be_quick(candidate: Candidate, something_found: bool) -> bool:
    if something_found:
        return not candidate.swings
    return any(schema.scan in QUICK for schema in candidate.shapes)


def _ends_at_steps(inquiry: Inquiry) -> bool:
    """Whether the band ends where one joint's motion sinks into the steps of its encoder, others being better known.

    What is quicker was seen to be that joint's (``below_steps``).
    """
    motions = [r.motion for r in inquiry.setting.readings]
    return inquiry.case.bench.edge <= min(motions) < max(motions)
