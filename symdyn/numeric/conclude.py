"""The end of a diagnosis: the new specification, its re-emitted kernel, the verdict, what is left."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.compiler import robot_from_text
from symdyn.numeric.alarms import absorbing, even, unearthly, weightless
from symdyn.numeric.beyond_noise import beyond_noise, left_by_positions
from symdyn.numeric.cut import UNCUT, Part
from symdyn.numeric.explanation import Case, Explanation, joint_errors
from symdyn.numeric.findings import Diagnosis, Errors, Located, NoiseFloor, Remaining, Traces, Verdict
from symdyn.numeric.fitting import relative_error
from symdyn.numeric.free_form import fitted_of
from symdyn.numeric.geared_values import with_elsewhere
from symdyn.numeric.groups import rigid_group
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.law import refuted
from symdyn.numeric.leftover import leftover, variables
from symdyn.numeric.locate import Left, located, with_found
from symdyn.numeric.mechanics import mechanical_kernel
from symdyn.numeric.noise_floor import in_band, independent_samples, noise_density
from symdyn.numeric.rounding import left_by_steps
from symdyn.numeric.skew import skew_left
from symdyn.numeric.standstill import admissible_residual
from symdyn.numeric.verdict import EXPLAINED, HOLDS, that_matters, verdict_of
from symdyn.numeric.workbench import Workbench
from symdyn.physics import in_stages
from symdyn.spec.edit import add_effect, set_effect, set_parameter
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

FOUND = "found by symdyn diagnose"


def conclude(inquiry: Inquiry, training: str, heldout: str) -> Diagnosis:
    """Write the new robot, re-emit its kernel, and take every number "after" from that kernel."""
    case, final, first, given = inquiry.case, inquiry.current, inquiry.first, inquiry.given
    findings, alarms = inquiry.findings, inquiry.alarms
    diagnosed = specification(case, final, inquiry.setting.part)
    emitted = mechanical_kernel(inquiry.setting.part.of(diagnosed))
    bench = Workbench(emitted, case.bench.observation, case.bench.band)
    judge = Workbench(emitted, case.judge.observation, case.judge.band)
    r_training, r_heldout = bench.residual(emitted.values), judge.residual(emitted.values)
    after = Errors(relative_error(r_training, bench.reference), relative_error(r_heldout, judge.reference))
    densities = [noise_density(each, emitted.values) for each in (bench, judge)]
    steps = left_by_steps(inquiry)
    ways = list(zip((bench, judge), densities, steps, strict=True))
    noise = [np.hypot(in_band(density, each), left) for each, density, left in ways]  # of efforts, and of encoders
    sampled = case.left_by_sampling(final)
    unseen = np.hypot(steps[1], np.sqrt(np.mean(sampled**2, axis=0)))  # (n,) what samples and steps do not show
    admitted = [admissible_residual(each, emitted.values) for each in (bench, judge)]
    beyond = beyond_noise(judge, emitted.values, admitted[1], unseen)
    remaining = leftover(
        (admitted[0], bench.motion),
        (admitted[1], judge.motion),
        variables(case.joints),
        dict(zip(case.joints, joint_errors(r_heldout, judge).tolist(), strict=True)),
        judge.samples_per_period,
        noise[1],
        float(np.min(judge.observation.motions)) / judge.edge,
        beyond,
    )
    whole = [np.hypot(in_band(d, b), np.maximum(s, left_by_positions(b, emitted.values))) for b, d, s in ways]
    shown = joint_errors(given.training, first.bench), joint_errors(given.heldout, first.judge)
    told = []
    skew = skew_left(case, final)
    if skew is not None:
        told.append(f"{skew.text} would tell {100 * skew.share:.0f} % of what is left")
        if not remaining.structured:
            size = math.sqrt(skew.share) * after.heldout
            remaining = Remaining(after.heldout, True, skew.share, "lateness of the efforts", skew.p_value, size)
    told += even(beyond, case.joints, remaining)
    hidden = dict(zip(case.joints, _relative(unseen, judge).tolist(), strict=True))
    remaining = that_matters(remaining, findings, hidden)
    groups = dict(zip(case.joints, map(rigid_group, case.robot.joints), strict=True))
    wrong, before = refuted(case, final, remaining), first.errors(given)
    verdict = verdict_of(findings, remaining, before, after, HOLDS if wrong else EXPLAINED)
    if verdict is Verdict.UNEXPLAINED:
        told += [f"the law of {x} does not hold: what is left follows the {remaining.variable}" for x in wrong]
    told += [*weightless(first.robot, case, final), *unearthly(case, final), *absorbing(case, final)]
    return Diagnosis(
        verdict=verdict,
        robot=first.robot,
        diagnosed=diagnosed,
        findings=tuple(with_elsewhere(case.robot, each) for each in findings),
        model=case.model_parameters(final),
        before=before,
        after=after,
        per_joint=_of_each(case, joint_errors(r_training, bench), joint_errors(r_heldout, judge)),
        remaining=remaining,
        alarms=tuple(dict.fromkeys((*alarms, *told))),
        band=case.bench.band.cutoff if case.bench.band else 0.0,
        training=training,
        heldout=heldout,
        traces=_traces((first.judge, given.fit.p), (judge, emitted.values), densities[1], tuple(case.joints)),
        located=_with_rest(with_found(where_and_when(first, given), findings), remaining, judge, groups),
        noise_floor=_noise_floor(case, (bench, judge), whole),
        per_joint_before=_of_each(case, *shown),
        judged="effort" if np.any(judge.effort) else "inertial effort",
    )


def where_and_when(case: Case, given: Explanation) -> tuple[Located, ...]:
    """Where the model as given is not enough, by what each joint's residual follows."""
    residuals = Left(*(admissible_residual(w, given.fit.p) * given.weight for w in (case.bench, case.judge)))
    groups = [rigid_group(joint) for joint in case.robot.joints]
    return located(case.bench, case.judge, fitted_of(case, given), residuals, groups)


def _with_rest(
    located: tuple[Located, ...], rest: Remaining, judge: Workbench, groups: Mapping[str, Sequence[str]]
) -> tuple[Located, ...]:
    """Where what is left is at a joint that nothing pointed at before: that one, too, by how much of it is no noise."""
    if not rest.structured or rest.place is None or rest.place in {place.place for place in located}:
        return located
    told = min(rest.unlike_noise, 1.0 - 1e-9)
    evidence = -0.5 * independent_samples(judge) * math.log1p(-told)
    when = (rest.variable or ("slow" if rest.slow >= rest.beyond_noise else "quick"),)
    found = Located(rest.place, tuple(groups[rest.place]), evidence, when)
    return tuple(sorted((*located, found), key=lambda place: -place.evidence))


def _noise_floor(case: Case, benches: Sequence[Workbench], noise: Sequence[Array]) -> NoiseFloor:
    """What noise of this root mean square (n,) alone would leave, relative to the effort (or what stands for it)."""
    shares = [_relative(left, bench) for bench, left in zip(benches, noise, strict=True)]
    whole = [float(np.sqrt(np.mean(share[case.bench.observation.tested] ** 2))) for share in shares]
    return NoiseFloor(Errors(*whole), _of_each(case, *shares))


def _of_each(case: Case, training: Array, heldout: Array) -> dict[str, Errors]:
    """By joints of which the equation was tested."""
    each = zip(case.joints, training, heldout, case.bench.observation.tested, strict=True)
    return {joint: Errors(float(a), float(b)) for joint, a, b, tested in each if tested}


def _relative(left: Array, bench: Workbench) -> Array:
    """(n,) a root mean square, of that of the effort (or what stands for it)."""
    size: Array = np.sqrt(np.mean(bench.reference**2, axis=0))
    return np.divide(left, size, out=np.zeros_like(size), where=size > 0.0)


def specification(case: Case, final: Explanation, part: Part) -> Robot:
    """The whole model's own TOML with fitted parameters and one [[effect]] per finding; comments are kept."""
    text, file = case.robot.text, case.robot.where.file if case.robot.where else case.robot.name
    # Of a part, too: its own record has fewer effects than the text.
    whole = case.robot if part == UNCUT else robot_from_text(text, file)
    for name, estimate in case.model_parameters(final).items():
        text = set_parameter(text, whole, name, estimate.written)
    for candidate, _ in sorted(final.found, key=lambda item: item[0].number):
        values = {k: e.written for k, e in case.parameters(candidate, final).items()}
        text = add_effect(text, candidate.effect, part.place(candidate.effect, candidate.place.address), values, FOUND)
    for revised in in_stages(r for r in case.revised if r.values):
        values = {k: e.written for k, e in revised.values.items()}
        text = set_effect(text, revised.effect, part.place(revised.effect, revised.place), values, FOUND)
    return robot_from_text(text, file)


def _traces(
    given: tuple[Workbench, Array], final: tuple[Workbench, Array], noise: Array, joints: tuple[str, ...]
) -> Traces:
    """Of all that was held out: where a joint stands, too, though nothing is counted there."""
    judge = final[0]
    o = judge.observation
    at = np.flatnonzero(o.tested)
    effort = judge.bring(o.tau) * o.shown
    before, after = (
        bench.bring(bench.observation.tau - bench.raw_residual(p)) * bench.observation.shown
        for bench, p in (given, final)
    )
    return Traces(
        time=judge.bring(o.time[:, None])[:, 0],
        q=judge.bring(o.q)[:, at],
        qd=judge.bring(o.qd)[:, at],
        effort=effort[:, at],
        before=before[:, at],
        after=after[:, at],
        joints=tuple(joints[i] for i in at),
        effort_units=tuple(judge.kernel.effort_units[i] for i in at),
        noise=noise[at],
    )
