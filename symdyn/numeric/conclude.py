"""The end of a diagnosis: the new specification, its re-emitted kernel, the verdict, what is left."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.compiler import compile_robot, robot_from_text
from symdyn.numeric.candidates import bounds
from symdyn.numeric.explanation import Case, Explanation, joint_errors
from symdyn.numeric.findings import Diagnosis, Errors, Finding, Remaining, Traces, Verdict
from symdyn.numeric.fitting import relative_error
from symdyn.numeric.leftover import leftover
from symdyn.numeric.workbench import Workbench
from symdyn.spec.edit import add_effect, set_parameter
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

DIGITS = 8  # of fitted values in a specification: far below any standard error


def conclude(
    case: Case,
    given: Explanation,
    final: Explanation,
    findings: Sequence[Finding],
    alarms: Sequence[str],
    training: str,
    heldout: str,
) -> Diagnosis:
    """Write the new robot, re-emit its kernel, and take every number "after" from that kernel."""
    diagnosed = specification(case, final)
    emitted = compile_robot(diagnosed).kernel()
    bench = Workbench(emitted, case.bench.observation, case.bench.band)
    judge = Workbench(emitted, case.judge.observation, case.judge.band)
    r_training, r_heldout = bench.residual(emitted.values), judge.residual(emitted.values)
    after = Errors(relative_error(r_training, bench.reference), relative_error(r_heldout, judge.reference))
    remaining = leftover(
        (r_training, _motion(bench)),
        (r_heldout, _motion(judge)),
        [f"{what} of {joint}" for what in ("position", "speed", "acceleration") for joint in case.joints],
        after.heldout,
        judge.samples_per_period,
    )
    per_joint = zip(case.joints, joint_errors(r_training, bench), joint_errors(r_heldout, judge), strict=True)
    return Diagnosis(
        verdict=_verdict(findings, remaining),
        robot=case.robot,
        diagnosed=diagnosed,
        findings=tuple(findings),
        model=case.model_parameters(final),
        before=case.errors(given),
        after=after,
        per_joint={joint: Errors(float(a), float(b)) for joint, a, b in per_joint},
        remaining=remaining,
        alarms=tuple(dict.fromkeys((*alarms, *_absorbing(case, final)))),
        band=case.bench.band.cutoff if case.bench.band else 0.0,
        training=training,
        heldout=heldout,
        traces=_traces(case, given, judge, r_heldout),
    )


def specification(case: Case, final: Explanation) -> Robot:
    """The model's own TOML with fitted parameters and one [[effect]] per finding; comments are kept."""
    text = case.robot.text
    for name, estimate in case.model_parameters(final).items():
        text = set_parameter(text, case.robot, name, _value(estimate.value, estimate.unit))
    for candidate, _ in final.found:
        values = {k: _value(e.value, e.unit) for k, e in case.parameters(candidate, final).items()}
        text = add_effect(text, candidate.effect, candidate.place.address, values, "found by symdyn diagnose")
    file = case.robot.where.file if case.robot.where else case.robot.name
    return robot_from_text(text, file)


def _value(value: float, unit: str) -> str:
    return f"{value:.{DIGITS}g} {unit}".strip()


def _motion(bench: Workbench) -> Array:
    """(K, 3 n) position, speed and acceleration of the joints in the analysis band."""
    o = bench.observation
    return bench.bring(np.concatenate([o.q, o.qd, o.qdd], axis=1))


def _verdict(findings: Sequence[Finding], remaining: Remaining) -> Verdict:
    if any(f.rivals for f in findings):
        return Verdict.AMBIGUOUS
    if findings:
        return Verdict.MISSING_PHYSICS
    return Verdict.UNEXPLAINED if remaining.structured else Verdict.COMPLETE


def _absorbing(case: Case, final: Explanation) -> list[str]:
    """Parameters that ran to a bound: they are taking up structure that the model lacks."""
    limits = bounds(case.robot)
    return [
        f"{name} ran to its lower bound {limits[name][0]:.3g}: it may be absorbing missing structure"
        for name, estimate in case.model_parameters(final).items()
        if name in limits and estimate.value <= limits[name][0]
    ]


def _traces(case: Case, given: Explanation, judge: Workbench, after: Array) -> Traces:
    o = judge.observation
    return Traces(
        time=judge.bring(o.time[:, None])[:, 0],
        q=judge.bring(o.q),
        qd=judge.bring(o.qd),
        effort=judge.effort,
        before=judge.effort - given.heldout,
        after=judge.effort - after,
        joints=tuple(case.joints),
        effort_units=judge.kernel.effort_units,
    )
