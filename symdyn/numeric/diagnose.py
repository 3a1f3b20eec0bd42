"""The loop that closes: residual -> hypotheses -> fit -> held-out judgement -> a new specification."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import NumericalError
from symdyn.compiler import compile_robot, robot_from_text
from symdyn.numeric.band import Band, analysis_band, band_of
from symdyn.numeric.candidates import (
    Candidate,
    augmented,
    bounds,
    candidate_bounds,
    candidates,
    fitted_parameters,
)
from symdyn.numeric.findings import (
    Diagnosis,
    Errors,
    Estimate,
    Finding,
    Remaining,
    Rival,
    Traces,
    Verdict,
)
from symdyn.numeric.fitting import Fit, fit, joint_weight, relative_error
from symdyn.numeric.leftover import leftover
from symdyn.numeric.observation import Observation, observe
from symdyn.numeric.recording import Recording
from symdyn.numeric.regression import encompassing
from symdyn.numeric.search import TIE, Search, Trial, rank
from symdyn.numeric.workbench import Workbench
from symdyn.spec.edit import add_effect, set_parameter
from symdyn.spec.records import Robot

Array = NDArray[np.float64]
Progress = Callable[[str], None]

LEVEL = 0.01  # significance that a candidate must reach, all that was tried counted
EARNS = 0.03  # an effect that takes less than this part off the held-out error is not worth a line in a model
MAX_FINDINGS = 12


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """The explanation so far."""

    found: tuple[tuple[Candidate, float | None], ...]
    fit: Fit
    weight: Array
    training: Array  # (K, n) residuals in the analysis band
    heldout: Array


def diagnose(
    robot: Robot,
    training: Recording,
    heldout: Recording,
    *,
    band: float | None = None,
    progress: Progress = lambda _: None,
) -> Diagnosis:
    """Explain what the model lacks.

    Effects are chosen on ``training`` alone, by blocked cross-validation; ``heldout`` judges each
    one once. ``band`` in Hz fixes the analysis band (None: found from the residual).

    Raises InputError when the recordings do not measure what the model's equations need, and
    NumericalError when the model cannot be fitted.
    """
    bench, judge, proposed = _benches(robot, training, heldout, band, progress)
    own = fitted_parameters(robot)
    names = [name for name in own if _sensitive(bench, name)]
    state = first = _refit(bench, judge, robot, names, ())
    findings: list[Finding] = []
    alarms: list[str] = []
    while len(findings) < MAX_FINDINGS:
        search = Search(bench, state.fit.p, state.fit.names, state.weight, [j.name for j in robot.joints])
        ready = [c for c in proposed if _ready(c, robot, state)]
        earning, refused = rank(search, ready, LEVEL, lambda what, n=len(findings) + 1: progress(f"step {n}: {what}"))
        alarms += [f"{t.candidate.label} would fit only with a value outside its bounds" for t in refused]
        accepted = None
        for trial in earning:
            try:
                better = _refit(bench, judge, robot, names, (*state.found, (trial.candidate, trial.shape)))
            except NumericalError:
                alarms.append(f"{trial.candidate.label} could not be fitted: it does not settle")
                continue
            if _earns(state, better, judge):
                accepted = (trial, better)
                break
            alarms.append(f"{trial.candidate.label} fits the training data better, but not the held-out data")
        if accepted is None:
            break
        findings.append(_finding(accepted[0], state, accepted[1], judge))
        state = accepted[1]
        progress(f"found: {findings[-1].title} at {findings[-1].place}")
    state, findings = _reexamine(bench, judge, robot, names, state, findings, alarms)
    progress("looking for rivals")
    findings = _with_rivals(bench, names, state, findings, proposed, [j.name for j in robot.joints])
    return _conclude(robot, training, heldout, bench, judge, first, state, findings, alarms, proposed)


def _benches(
    robot: Robot, training: Recording, heldout: Recording, band: float | None, progress: Progress
) -> tuple[Workbench, Workbench, tuple[Candidate, ...]]:
    """One kernel with every candidate in it, on both recordings, in the band where the mismatch lives."""
    proposed = candidates(robot)
    progress(f"deriving and compiling {robot.name} with {len(proposed)} candidate effects")
    kernel = compile_robot(augmented(robot, proposed)).kernel()
    seen = observe(robot, kernel, training)
    wide = Workbench(kernel, seen)
    names = [name for name in fitted_parameters(robot) if _sensitive(wide, name)]
    start = fit(wide, kernel.values, names, joint_weight(seen.tau, seen.tau), bounds(robot))
    chosen: Band = (
        analysis_band(wide.raw_residual(start.p), seen) if band is None else band_of(band, seen.rate)
    )
    # Derivatives need room above the band, and no more (Gautier, Janot: five times the dynamics).
    cutoff = 5.0 * chosen.cutoff
    return (
        Workbench(kernel, observe(robot, kernel, training, cutoff), chosen),
        Workbench(kernel, observe(robot, kernel, heldout, cutoff), band_of(chosen.cutoff, 1 / heldout.sample_time)),
        proposed,
    )


def _refit(
    bench: Workbench, judge: Workbench, robot: Robot, names: Sequence[str], found: tuple[tuple[Candidate, float | None], ...]
) -> _State:
    p = bench.kernel.values
    fitted, limits = list(names), bounds(robot)
    for candidate, shape in found:
        limits |= candidate_bounds(candidate, shape)
        fitted += [candidate.parameter(schema) for schema in candidate.linear]
        if candidate.shape is not None and shape is not None:
            p[bench.index[candidate.parameter(candidate.shape)]] = shape
            fitted.append(candidate.parameter(candidate.shape))
    weight = np.ones(bench.effort.shape[1])
    for _ in range(2):  # the weights follow the size of each joint's residual
        done = fit(bench, p, fitted, weight, limits)
        weight = joint_weight(bench.residual(done.p), bench.effort)
    return _State(found, done, weight, bench.residual(done.p), judge.residual(done.p))


def _sensitive(bench: Workbench, name: str) -> bool:
    return bool(np.any(bench.columns(bench.kernel.values, [name])))


def _ready(candidate: Candidate, robot: Robot, state: _State) -> bool:
    """Not found yet, and what it corrects is in the model."""
    found = {(c.effect, c.place.address) for c, _ in state.found}
    present = found | {(e.type, e.at) for e in robot.effects}
    here = candidate.place.address
    basis = candidate.builds_on is None or (candidate.builds_on, here) in present
    return basis and (candidate.effect, here) not in found


def _gain(before: _State, after: _State) -> tuple[float, float]:
    return encompassing(before.heldout * before.weight, after.heldout * before.weight)


def _earns(before: _State, after: _State, judge: Workbench) -> bool:
    """Held-out error falls by more than chance, and by enough to matter, over all joints it touches."""
    gain, p_value = _gain(before, after)
    old, new = _errors(before.heldout, judge), _errors(after.heldout, judge)
    enough = bool(np.any(new <= (1.0 - EARNS) * old))
    return gain > 0 and p_value < LEVEL and enough


def _errors(residual: Array, judge: Workbench) -> Array:
    """(n,) relative error per joint."""
    return np.array([relative_error(residual[:, [j]], judge.effort[:, [j]]) for j in range(residual.shape[1])])


def _finding(trial: Trial, before: _State, after: _State, judge: Workbench) -> Finding:
    candidate = trial.candidate
    return Finding(
        candidate.effect,
        candidate.title,
        candidate.place.address,
        _parameters(candidate, after.fit, judge),
        relative_error(before.heldout, judge.effort),
        relative_error(after.heldout, judge.effort),
        _gain(before, after)[1],
        (),
    )


def _parameters(candidate: Candidate, fitted: Fit, bench: Workbench) -> dict[str, Estimate]:
    schemas = (*candidate.linear, *((candidate.shape,) if candidate.shape is not None else ()))
    return {
        schema.name: Estimate(
            float(fitted.p[bench.index[candidate.parameter(schema)]]),
            fitted.standard_error(candidate.parameter(schema)),
            candidate.unit(schema),
        )
        for schema in schemas
    }


def _reexamine(
    bench: Workbench,
    judge: Workbench,
    robot: Robot,
    names: Sequence[str],
    state: _State,
    findings: list[Finding],
    alarms: list[str],
) -> tuple[_State, list[Finding]]:
    """Earlier findings that later ones have made needless are taken out again; values are those of the end."""
    for candidate, shape in list(state.found[:-1]):
        dependent = any(
            c.builds_on == candidate.effect and c.place == candidate.place for c, _ in state.found
        )
        if dependent:
            continue
        rest = tuple(item for item in state.found if item != (candidate, shape))
        without = _refit(bench, judge, robot, names, rest)
        if not _earns(without, state, judge):
            alarms.append(f"{candidate.label} was taken out again: later findings explain it better")
            findings = [f for f in findings if (f.effect, f.place) != (candidate.effect, candidate.place.address)]
            state = without
    by_place = {(c.effect, c.place.address): c for c, _ in state.found}
    final = []
    for finding in findings:
        candidate = by_place[finding.effect, finding.place]
        final.append(replace(finding, parameters=_parameters(candidate, state.fit, bench)))
    return state, final


def _with_rivals(
    bench: Workbench,
    names: Sequence[str],
    state: _State,
    findings: Sequence[Finding],
    proposed: Sequence[Candidate],
    joints: Sequence[str],
) -> list[Finding]:
    """For each finding, what else could stand in its place: cross-validated losses that chance cannot tell apart."""
    present = {(c.effect, c.place.address) for c, _ in state.found}
    result = []
    for finding in findings:
        mine = next(item for item in state.found if (item[0].effect, item[0].place.address) == (finding.effect, finding.place))
        kept = [item for item in state.found if item is not mine]
        linear = [*names, *(c.parameter(s) for c, _ in kept for s in c.linear)]
        p = state.fit.p.copy()
        for schema in mine[0].linear:
            p[bench.index[mine[0].parameter(schema)]] = schema.null or 0.0
        search = Search(bench, p, linear, state.weight, joints)
        own = search.trial(mine[0])
        rivals = []
        for other in proposed:
            same_joint = other.place == mine[0].place
            others = present - {(mine[0].effect, mine[0].place.address)}
            corrects = other.builds_on is not None and (other.builds_on, other.place.address) not in others
            if not same_joint or corrects or (other.effect, other.place.address) in present:
                continue
            trial = search.trial(other)
            p_value = encompassing(trial.errors, own.errors)[1]
            if trial.admissible and trial.gain > 0 and p_value > TIE:
                rivals.append(Rival(other.effect, other.place.address, p_value))
        result.append(replace(finding, rivals=tuple(rivals)))
    return result


def _conclude(
    robot: Robot,
    training: Recording,
    heldout: Recording,
    bench: Workbench,
    judge: Workbench,
    first: _State,
    state: _State,
    findings: Sequence[Finding],
    alarms: list[str],
    proposed: Sequence[Candidate],
) -> Diagnosis:
    diagnosed = specification(robot, bench, state)
    alarms = [*alarms, *_absorbing(robot, bench, state)]
    emitted = compile_robot(diagnosed).kernel()
    # The numbers after come from the re-emitted kernel of the new specification, not from the search.
    after_bench, after_judge = (Workbench(emitted, b.observation, b.band) for b in (bench, judge))
    r_training, r_heldout = after_bench.residual(emitted.values), after_judge.residual(emitted.values)
    remaining = leftover(
        (r_training, _variables(after_bench)),
        (r_heldout, _variables(after_judge)),
        [f"{what} of {joint.name}" for what in ("position", "speed", "acceleration") for joint in robot.joints],
        relative_error(r_heldout, judge.effort),
    )
    motion = judge.band.bring(np.stack([judge.observation.q, judge.observation.qd], axis=1), judge.observation)  # type: ignore[union-attr]
    time = judge.band.bring(judge.observation.time[:, None], judge.observation)[:, 0]  # type: ignore[union-attr]
    own = {n: Estimate(float(state.fit.p[bench.index[n]]), state.fit.standard_error(n), _unit(bench, n)) for n in first.fit.names}
    return Diagnosis(
        verdict=_verdict(findings, remaining),
        robot=robot,
        diagnosed=diagnosed,
        findings=tuple(findings),
        model=own,
        before=Errors(relative_error(first.training, bench.effort), relative_error(first.heldout, judge.effort)),
        after=Errors(relative_error(r_training, bench.effort), relative_error(r_heldout, judge.effort)),
        per_joint={
            joint.name: Errors(float(_errors(r_training, bench)[j]), float(_errors(r_heldout, judge)[j]))
            for j, joint in enumerate(robot.joints)
        },
        remaining=remaining,
        alarms=tuple(dict.fromkeys(alarms)),
        band=bench.band.cutoff if bench.band else 0.0,
        training=training.name,
        heldout=heldout.name,
        traces=Traces(
            time, motion[:, 0], motion[:, 1], judge.effort,
            judge.effort - first.heldout, judge.effort - r_heldout,
            tuple(j.name for j in robot.joints), tuple(emitted.EFFORT_UNITS),
        ),
    )  # fmt: skip


def specification(robot: Robot, bench: Workbench, state: _State) -> Robot:
    """The model's own TOML with fitted parameters and one [[effect]] per finding; comments are kept."""
    text = robot.text
    for name in state.fit.names:
        if name in {p.name for p in robot.parameters}:
            value = f"{float(state.fit.p[bench.index[name]]):.8g} {_unit(bench, name)}".strip()
            text = set_parameter(text, robot, name, value)
    for candidate, _ in state.found:
        values = {k: f"{e.value:.8g} {e.unit}" for k, e in _parameters(candidate, state.fit, bench).items()}
        text = add_effect(text, candidate.effect, candidate.place.address, values)
    file = robot.where.file if robot.where else robot.name
    return robot_from_text(text, file)


def _absorbing(robot: Robot, bench: Workbench, state: _State) -> list[str]:
    """Parameters that ran to a bound: they are taking up structure that the model lacks."""
    limits = bounds(robot)
    values = {name: float(state.fit.p[bench.index[name]]) for name in state.fit.names if name in limits}
    return [
        f"{name} ran to its lower bound {limits[name][0]:.3g}: it may be absorbing missing structure"
        for name, value in values.items()
        if value <= limits[name][0]
    ]


def _unit(bench: Workbench, name: str) -> str:
    return bench.kernel.parameter_units[bench.index[name]]


def _variables(bench: Workbench) -> Array:
    o: Observation = bench.observation
    assert bench.band is not None
    return bench.band.bring(np.concatenate([o.q, o.qd, o.qdd], axis=1), o)


def _verdict(findings: Sequence[Finding], remaining: Remaining) -> Verdict:
    if any(f.rivals for f in findings):
        return Verdict.AMBIGUOUS
    if findings:
        return Verdict.MISSING_PHYSICS
    return Verdict.UNEXPLAINED if remaining.structured else Verdict.COMPLETE
