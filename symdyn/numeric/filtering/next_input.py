"""What to record next where only part of a machine is measured: the input under which two explanations differ."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.base.wording import quoted
from symdyn.numeric.candidates import Candidate
from symdyn.numeric.experiment.design import SEPARATES, WIDER
from symdyn.numeric.experiment.limits import Visited, experiment_limits
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.explain import with_effect
from symdyn.numeric.filtering.hypotheses import hypotheses
from symdyn.numeric.filtering.imagined import Explaining
from symdyn.numeric.filtering.input_design import Contest, Designed, Inputs, Range, design
from symdyn.numeric.filtering.judged import Explanation, explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import Model, candidate_beliefs, prepare, without_latent
from symdyn.numeric.filtering.score import scores
from symdyn.numeric.filtering.side_by_side import side_by_side
from symdyn.numeric.findings import Diagnosis, Finding, NextExperiment
from symdyn.numeric.recording import Recording
from symdyn.physics import catalogue
from symdyn.spec.records import Robot

Array = NDArray[np.float64]
Progress = Callable[[str], None]
Pair = tuple[tuple[str, str], tuple[str, str]]

ROOM = 0.995  # quantile of a recorded speed that counts as its top: noise has extremes of its own
FEW = 8  # rounds of a fit from a diagnosed model


@dataclass(frozen=True, slots=True, eq=False)
class NextInput:
    """``columns`` by name with unit, ``time [s]`` and each input; None where none could be designed."""

    told: NextExperiment
    columns: Mapping[str, Array] | None = None


def next_input(
    diagnosis: Diagnosis,
    training: Recording,
    given: Mapping[str, Mapping[str, float]],
    duration: float,
    seed: int,
    progress: Progress,
) -> NextInput | None:
    """The input that separates the first finding that has rivals from the likeliest of them.

    ``given`` limits (lower, upper, velocity, input) by joint; else the robot's own, else what the recording visited.
    None where the diagnosis left no such question. Raises InputError as ``prepare`` does.
    """
    asked = [(f, other) for f in diagnosis.findings for other in f.others]
    if not asked:
        return None
    for finding, other in asked:
        between = ((finding.effect, finding.place), other)
        base = _without(diagnosis.diagnosed, finding)
        known = {(c.effect, c.place.address): c.label for c in hypotheses(base)}
        if all(key in known for key in between):
            break
    else:
        return _none_for(asked)
    progress("deriving and compiling the explanations")
    model = prepare(base, training, training, only=tuple(known[key] for key in between))
    start = _fitted(model)
    by_place = {(c.effect, c.place.address): c for c in model.proposed}
    progress("fitting both explanations")
    pair = [_explaining(model, start, by_place[key]) for key in between]
    step = float(np.nanmedian(model.training.steps))
    ranges, reach, assumed = _limits(model, start, given)
    inputs = Inputs(np.median(model.training.u, axis=0), reach, round(duration / step), step)
    found = design(Contest((pair[0], pair[1]), inputs, ranges), seed, progress)
    told = NextExperiment(between, found.separation, None, _words(found, between, duration, assumed))
    return NextInput(told, None if found.u is None or not found.separation else _columns(model, found.u, step))


def _without(robot: Robot, finding: Finding) -> Robot:
    """The robot without an effect that was found, and what corrects it there; their numbers were their own."""
    gone = {finding.effect} | {e for e, law in catalogue().items() if law.builds_on == finding.effect}
    out = [e for e in robot.effects if e.at == finding.place and e.type in gone]
    own = {name for e in out for _, value in e.values for name, _ in value.factors}
    effects = tuple(e for e in robot.effects if e not in out)
    return replace(robot, effects=effects, parameters=tuple(p for p in robot.parameters if p.name not in own))


def _none_for(asked: list[tuple[Finding, tuple[str, str]]]) -> NextInput | None:
    """Where one of the two is no force at a place of its own: parts that are rigid to each other, or a state more."""
    for finding, other in asked:
        if other[0] != finding.effect:
            between = ((finding.effect, finding.place), other)
            names = f"{_name(between[0])} and {_name(other)}"
            told = f"no input was designed between {names}: one of them changes the states of the machine"
            return NextInput(NextExperiment(between, 0.0, None, told))
    return None


def _fitted(model: Model) -> Explanation:
    """The diagnosed model without the finding, with its noise; inputs held or straight, as fits better."""
    noise = without_latent(model, model.training)

    def roughly(between: Between) -> Explanation:
        bench = model.bench(model.training, noise, between)
        return explained(model, (), model.beliefs, fit(bench, model.values, model.beliefs, most=FEW))

    return min(side_by_side(roughly, (Between.STRAIGHT, Between.HELD)), key=lambda each: each.fit.loss)


def _explaining(model: Model, start: Explanation, candidate: Candidate) -> Explaining:
    """One of the two, at the best value of its shape, fitted with everything else."""
    (score,) = scores(start.fit.bench, start.fit.p, start.fit.names, [candidate])
    rough = with_effect(model, start, candidate, score.shape, score.estimate)
    beliefs = dict(start.beliefs) | candidate_beliefs(candidate, score.shape)
    return Explaining(model, candidate, fit(rough.bench, rough.p, beliefs))


def _limits(
    model: Model, start: Explanation, given: Mapping[str, Mapping[str, float]]
) -> tuple[dict[int, Range], Array, str]:
    """Ranges of the joints, by their coordinate, and how far each input may go from its middle (nu,).

    Given, or declared, or visited; and in words what was only visited. Raises UsageError (SD330) as limits do.
    """
    kernel, u, names = model.kernel, model.training.u, [joint.name for joint in model.robot.joints]
    states, n = start.fit.bench.filtered(start.fit.p).states, len(kernel.coordinates)
    at = [kernel.coordinates.index(name) for name in names]
    q, qd = states[:, at], states[:, [n + i for i in at]]
    unlimited = np.full(len(names), np.inf)
    seen = Visited(q.min(axis=0), q.max(axis=0), np.quantile(np.abs(qd), ROOM, axis=0), unlimited, unlimited)
    limits = experiment_limits(model.robot, given, seen)
    ranges = {i: (own.lower, own.upper, own.velocity) for i, own in zip(at, limits.joints, strict=True)}
    middle, owner = np.median(u, axis=0), [names.index(name.partition(".")[0]) for name in kernel.inputs]
    told = np.array([limits.joints[j].input for j in owner])
    reach = np.where(np.isfinite(told), np.maximum(told - np.abs(middle), 0.0), np.max(np.abs(u - middle), axis=0))
    taken = [f"{f} of {name}" for name in names for f in _needed(model, name) if f not in given.get(name, {})]
    return ranges, reach, f"what the recording visited stands for the {', '.join(taken)}" if taken else ""


def _needed(model: Model, joint: str) -> list[str]:
    """Limits that no model declares."""
    own = next(j.limits for j in model.robot.joints if j.name == joint)
    declared = [f for f in ("lower", "upper", "velocity") if own is not None and getattr(own, f, None) is not None]
    driven = any(name.partition(".")[0] == joint for name in model.kernel.inputs)
    return [f for f in ("lower", "upper", "velocity", *(["input"] if driven else [])) if f not in declared]


def _columns(model: Model, u: Array, step: float) -> dict[str, Array]:
    kernel = model.kernel
    names = [f"{name} [{unit}]" for name, unit in zip(kernel.inputs, kernel.input_units, strict=True)]
    return {"time [s]": step * np.arange(len(u))} | dict(zip(names, u.T, strict=True))


def _words(found: Designed, between: Pair, duration: float, assumed: str) -> str:
    one, other = (_name(key) for key in between)
    if found.u is None and not all(found.nested):
        return f"no input keeps the machine within its limits; {assumed}" if assumed else "no input keeps the limits"
    if all(found.nested):
        return f"{one} and {other} answer every input alike: another sensor, or another load, is needed"
    sentences = []
    if found.separation >= SEPARATES:
        sentences.append(
            f"under this input of {duration:.3g} s the wrong one of {one} and {other}, fitted anew, loses "
            f"{_nats(found.separation)} nats of log-likelihood in a simulated recording; the usual input within the "
            f"same limits promises {_nats(found.usual)}"
        )
    else:
        sentences.append(
            f"no input of {duration:.3g} s within the limits separates {one} from {other} surely: the best shows "
            f"{found.separation:.2g} nats of the {SEPARATES:g} that are asked for"
        )
        more = f"{found.wider:g} times the input, travel and speed would"
        sentences.append(more if found.wider else f"nor do limits {WIDER[-1]:g} times as wide")
    for truth, nested in enumerate(found.nested):
        if nested:
            true, wide = (one, other) if truth == 0 else (other, one)
            sentences.append(f"if {true} is true, {wide} fits as well, with what it has more coming out as zero")
    return "; ".join([*sentences, *([assumed] if assumed else [])])


def _nats(value: float) -> str:
    return f"{value:.0f}" if value >= 100.0 else f"{value:.2g}"


def _name(key: tuple[str, str]) -> str:
    effect, place = key
    return f"{catalogue()[effect].title if effect in catalogue() else quoted(effect)} at {place}"
