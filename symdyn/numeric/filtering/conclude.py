"""The end of a diagnosis by filter: the new specification, its re-emitted kernel, and every fact about both."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symdyn.compiler import compile_robot, robot_from_text
from symdyn.numeric.candidates import Candidate
from symdyn.numeric.filtering.alarms import moved, out_of_reach, without_interval
from symdyn.numeric.filtering.explain import ROUGH, ROUNDS
from symdyn.numeric.filtering.hypotheses import kept
from symdyn.numeric.filtering.judged import WORTH, Explanation
from symdyn.numeric.filtering.law import left_to_follow, refuted
from symdyn.numeric.filtering.likelihood import ITERATIONS, MLFit, fit
from symdyn.numeric.filtering.locate import Place, together
from symdyn.numeric.filtering.missing_force import missing_forces
from symdyn.numeric.filtering.model import PRIOR, Freed, Model
from symdyn.numeric.filtering.when import when
from symdyn.numeric.filtering.windows import SHARE, beyond, noise_alone, overall
from symdyn.numeric.findings import (
    Diagnosis,
    Errors,
    Estimate,
    Finding,
    Located,
    NoiseFloor,
    Remaining,
    Traces,
    Verdict,
)
from symdyn.numeric.verdict import ALL, EXPLAINED, HOLDS, that_matters, verdict_of
from symdyn.physics import catalogue, in_stages
from symdyn.spec.edit import add_effect, free_rotor, set_effect, set_parameter
from symdyn.spec.records import JOINT_END, Robot

Array = NDArray[np.float64]

TOLD = 0.9  # of the prior's width: what a recording narrows less it does not tell
UNMOVED = 1e-9  # of a number: a fit that changed no more leaves what the model says of it as it was written


def conclude(
    model: Model,
    as_given: Model,
    robot: Robot,
    places: Sequence[Place],
    given: Explanation,
    final: Explanation,
    findings: Sequence[Finding],
    alarms: Sequence[str],
    names: tuple[str, str],
) -> Diagnosis:
    """``robot`` is the model as given, ``as_given`` the same for a filter; ``names``: of the two recordings."""
    diagnosed = specification(model, robot, final)
    compile_robot(diagnosed).kernel()  # re-emitted: the diagnosis ends with a kernel that runs
    before, after = (Errors(overall(e.errors[0]), overall(e.errors[1])) for e in (given, final))
    floor = noise_floor(model, final.fit)
    remaining = that_matters(left_over(model, final, after, floor), findings, {})
    channels, mismatch = model.heldout.judged, beyond(before.heldout, floor.errors.heldout) > SHARE
    far = moved(model, final.fit)
    wrong = refuted(model, final) if remaining.structured else ()
    verdict = verdict_of(findings, remaining, before, after, ALL if far else HOLDS if wrong else EXPLAINED)
    told = [f"the law of {law} does not hold: what is left follows the {variable} there" for law, variable in wrong]
    more = told if verdict is Verdict.UNEXPLAINED else []
    return Diagnosis(
        verdict=verdict,
        robot=robot,
        diagnosed=diagnosed,
        findings=tuple(findings),
        model={name: estimate(model, final.fit, name) for name in model.beliefs},
        before=before,
        after=after,
        per_joint={channel: Errors(float(a), float(b)) for channel, a, b in zip(channels, *final.errors, strict=True)},
        remaining=remaining,
        alarms=tuple(dict.fromkeys((*alarms, *far, *out_of_reach(model, final), *without_interval(findings), *more))),
        band=0.5 / float(np.nanmedian(model.training.steps)),
        training=names[0],
        heldout=names[1],
        traces=replace(_traces(model, given, final), missing=missing_forces(as_given, model, final, places, findings)),
        located=_located(as_given, given, places, findings) if mismatch else (),
        noise_floor=floor,
        judged="motion of the channels in free runs",
        per_joint_before={c: Errors(float(a), float(b)) for c, a, b in zip(channels, *given.errors, strict=True)},
    )


def specification(model: Model, robot: Robot, final: Explanation) -> Robot:
    """The model's own TOML with fitted parameters and one [[effect]] per finding; comments are kept."""
    text, file = robot.text, robot.where.file if robot.where else robot.name
    whole = robot_from_text(text, file)  # of a part, too: the effects of the text, one by one
    own = {parameter.name for parameter in robot.parameters}
    for name in (name for name in model.beliefs if name in own):
        own_value, given = estimate(model, final.fit, name), float(model.values[final.fit.bench.index[name]])
        if not math.isclose(own_value.value, given, rel_tol=UNMOVED):
            text = set_parameter(text, whole, name, own_value.written)
    for new in model.freed:
        values = {k: e.written for k, e in of_shaft(model, final, new).items()}
        shaft = {"name": new.shaft, "from": new.rotor, "to": JOINT_END, **values}
        text = free_rotor(text, whole, new.joint, new.rotor, shaft)
    for late in model.lagging:
        value = estimate(model, final.fit, late.parameter).written
        text = set_effect(text, late.effect, late.at, {late.name: value})
    for candidate in in_stages(candidate for candidate, _ in final.found):
        values = {k: e.written for k, e in parameters(model, final, candidate).items()}
        text = add_effect(text, candidate.effect, candidate.place.address, values, "found by symdyn diagnose")
    return robot_from_text(text, file)


def parameters(model: Model, of: Explanation, candidate: Candidate) -> dict[str, Estimate]:
    """The candidate's parameters as fitted, by their names in the effect's declaration."""
    schemas = (*candidate.linear, *candidate.shapes)
    found = {s.name: estimate(model, of.fit, candidate.parameter(s)) for s in schemas}
    units = {s.name: candidate.unit(s) for s in catalogue()[candidate.effect].parameters}
    return found | {name: Estimate(float(number), None, units[name]) for name, number in kept(candidate).items()}


def of_shaft(model: Model, of: Explanation, new: Freed) -> dict[str, Estimate]:
    """Stiffness and damping of a shaft between a rotor that was freed and its joint."""
    return {name: estimate(model, of.fit, getattr(new, name)) for name in ("stiffness", "damping")}


def estimate(model: Model, of: MLFit, name: str) -> Estimate:
    index = of.bench.index[name]
    value, unit = float(of.p[index]), model.unit(name)
    if name not in of.names:
        return Estimate(value, None, unit)
    i = of.names.index(name)
    se = float(np.sqrt(max(of.covariance[i, i], 0.0)))
    untold = name in model.beliefs and se >= TOLD * PRIOR * abs(value)
    return Estimate(value, None if untold or not math.isfinite(se) else se, unit)


def noise_floor(model: Model, of: MLFit) -> NoiseFloor:
    """What the sensors' noise alone would leave of the free-run error."""
    training, heldout = (noise_alone(signals, of.bench.noise.r) for signals in (model.training, model.heldout))
    channels = zip(model.training.judged, training, heldout, strict=True)
    per_channel: Mapping[str, Errors] = {name: Errors(float(a), float(b)) for name, a, b in channels}
    return NoiseFloor(Errors(overall(training), overall(heldout)), per_channel)


def left_over(model: Model, final: Explanation, after: Errors, floor: NoiseFloor) -> Remaining:
    """Whether an unknown force would still explain something, and how much of the held-out error is beyond noise.

    One that is let in may tell nothing, as noise of the inputs does its work; what follows the motion is no such noise.
    """
    unlike_noise = beyond(after.heldout, floor.errors.heldout)
    matters = unlike_noise > SHARE
    gain = _brought_by_force(final, matters)
    place, variable = left_to_follow(model, final) if matters and gain <= WORTH else (None, None)
    p_value = float(np.exp(-max(gain, WORTH if place else 0.0)))
    if not (matters and (gain > WORTH or place)):
        return Remaining(after.heldout, False, 0.0, None, p_value, 0.0)
    size = math.sqrt(unlike_noise) * after.heldout
    return Remaining(after.heldout, True, unlike_noise, variable, p_value, size, place)


def _brought_by_force(final: Explanation, matters: bool) -> float:
    """Nats that the unknown force of a fit is worth; 0 where it has none."""
    noise = final.fit.bench.noise
    if len(noise.power) == noise.inputs:
        return 0.0
    quiet = final.fit.bench.with_noise(noise.quiet)
    rounds = ITERATIONS if matters else ROUNDS  # the verdict does not hang on it
    none = fit(quiet, final.fit.p, final.beliefs, settled=ROUGH, most=rounds)
    return max(float(none.loss - final.fit.loss), 0.0)


def _located(
    model: Model, given: Explanation, places: Sequence[Place], findings: Sequence[Finding]
) -> tuple[Located, ...]:
    """``model`` as given: what the mismatch follows at the best place, and where something was found; of others no more
    than the place.
    """
    likely = [place for place in places if place.gain > WORTH]
    told = {likely[0].latent.place if likely else "", *(found.place for found in findings)}
    return tuple(
        Located(
            place.latent.place,
            together(place, places),
            place.gain,
            when(model, given, place.latent) if place.latent.place in told else (),
        )
        for place in likely
    )


def _traces(model: Model, given: Explanation, final: Explanation) -> Traces:
    heldout = model.heldout
    judge = model.bench(heldout, final.fit.bench.noise, final.fit.bench.between)
    states = judge.filtered(final.fit.p).states
    coordinates = model.kernel.coordinates
    at = []
    for name in heldout.names:
        own = [i for i, c in enumerate(coordinates) if name.startswith(f"{c}.")]
        same = [i for i, c in enumerate(coordinates) if c.partition(".")[0] == name.partition(".")[0]]
        at.append((own or same)[0])
    n = len(coordinates)
    shown = [np.where(np.isnan(e.predicted), heldout.y, e.predicted) for e in (given, final)]
    names = (*model.kernel.states, *model.kernel.outputs)
    units = dict(zip(names, (*model.kernel.state_units, *model.kernel.output_units), strict=True))
    return Traces(
        time=heldout.time,
        q=states[:, at],
        qd=states[:, [n + i for i in at]],
        effort=heldout.y,
        before=shown[0],
        after=shown[1],
        joints=heldout.names,
        effort_units=tuple(units[name] for name in heldout.names),
    )
