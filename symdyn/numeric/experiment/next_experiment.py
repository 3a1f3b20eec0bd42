"""The next experiment: between two models, for one model's parameters, or after a diagnosis that could not tell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError
from symdyn.numeric.band import band_of
from symdyn.numeric.experiment.design import EVALUATIONS, Design, design
from symdyn.numeric.experiment.explanations import Explained, best_refit, difference, explained
from symdyn.numeric.experiment.identification import Identifying, identifying
from symdyn.numeric.experiment.limits import Limits, Visited, experiment_limits, visited
from symdyn.numeric.experiment.motions import Family, Motion
from symdyn.numeric.experiment.searching import feasible
from symdyn.numeric.experiment.separation import Noise
from symdyn.numeric.experiment.words import hidden_words, identifying_words, separation_words
from symdyn.numeric.filtering.needed import has_hidden_parts
from symdyn.numeric.findings import Diagnosis, Finding, NextExperiment
from symdyn.numeric.fitting import joint_weight
from symdyn.numeric.mechanics import mechanics
from symdyn.numeric.observation import Observation, observe
from symdyn.numeric.recording import Recording
from symdyn.numeric.workbench import Workbench
from symdyn.physics import catalogue, load_dependent
from symdyn.spec.effect_schema import Scan
from symdyn.spec.places import places
from symdyn.spec.records import EffectSpec, Monomial, Parameter, Robot

Array = NDArray[np.float64]
Progress = Callable[[str], None]
Given = Mapping[str, Mapping[str, float]]  # limits by joint and name

DURATION = 20.0  # s
DERIVATIVE_ROOM = 5.0  # positions are low-passed this far above the band, as in the diagnosis


@dataclass(frozen=True, slots=True, eq=False)
class Planned:
    """``told`` is what a diagnosis says of it; ``motion`` None where none could be designed.

    Of a machine with hidden parts it is an input instead: ``columns`` by name with unit.
    """

    told: NextExperiment
    limits: Limits | None = None
    motion: Motion | None = None
    design: Design | None = None
    identifying: Identifying | None = None
    columns: Mapping[str, Array] | None = None


@dataclass(frozen=True, slots=True)
class Plan:
    """How an experiment is to be: its length (s), samples a second of its file, seed of the search, and its effort."""

    duration: float = DURATION
    rate: float = 500.0
    seed: int = 0
    evaluations: int = EVALUATIONS


def between_models(
    first: Robot, second: Robot, limits: Limits, noise: Noise, plan: Plan, progress: Progress = lambda _: None
) -> Planned:
    """The motion that separates two models, each of which is fitted anew to what the other would show.

    Raises InputError (SD332, SD333) where the joints do not show all motion, or no motion is possible. Where the
    models differ in how friction depends on the load of a shaft, the answer is another load, and no error.
    """
    progress(f"deriving and compiling {first.name} and its rival")
    between = _differing(first, second)
    joints = {joint.name for joint in first.joints}  # their loads follow from the motion, those of shafts do not
    if any(effect in load_dependent() and place not in joints for effect, place in between):
        return Planned(NextExperiment(between, 0.0, None, hidden_words(between, "the joints' motion is not the load")))
    return _between((explained(first), explained(second)), between, limits, noise, plan, progress)


def for_parameters(
    robot: Robot, limits: Limits, noise: Noise, plan: Plan, progress: Progress = lambda _: None
) -> Planned:
    """The motion that tells the parameters of one model best. Raises as ``between_models`` does."""
    progress(f"deriving and compiling {robot.name}")
    model = explained(robot)
    found = identifying(
        model, limits, noise, plan.duration, seed=plan.seed, evaluations=plan.evaluations, progress=progress
    )
    motion = _sampled(found.point, (model,), limits, plan)
    told = NextExperiment((), 0.0, None, identifying_words(found, plan.duration, limits.assumed))
    return Planned(told, limits, motion, identifying=found)


def after_diagnosis(
    diagnosis: Diagnosis, training: Recording, given: Given, plan: Plan, progress: Progress = lambda _: None
) -> Planned | None:
    """What to record next: to separate the best finding from its best rival, or to tell its parameters.

    Noise is what the diagnosed model leaves in the analysis band, limits those given, the robot's, or what the
    recording visited. None where the diagnosis left no such question.
    """
    if has_hidden_parts(diagnosis.robot, training):
        from symdyn.numeric.filtering.next_input import next_input  # compiles the filter as it is imported

        found = next_input(diagnosis, training, given, plan.duration, plan.seed, progress)
        return None if found is None else Planned(found.told, columns=found.columns)
    pair = _question(diagnosis)
    if pair is None:
        return None
    robot, rival, between = pair
    try:
        progress("deriving and compiling the explanations")
        model = explained(mechanics(robot))
        band = band_of(diagnosis.band, 1.0 / training.sample_time)
        seen = observe(robot, model.kernel, training, DERIVATIVE_ROOM * band.cutoff)
        bench = Workbench(model.kernel, seen, band)
        residual = bench.residual(model.p)
        noise = Noise(1.0 / joint_weight(residual, bench.effort), 2.0 * band.cutoff)
        limits = experiment_limits(robot, given, _visited(seen, bench))
        if rival is None:
            return for_parameters(robot, limits, noise, plan, progress)
        other = explained(mechanics(rival))
        other = other.with_values(best_refit(other, Workbench(other.kernel, seen, band), noise.weight))
    except InputError as error:
        reason = "; ".join(problem.message for problem in error.problems)
        return Planned(NextExperiment(between, 0.0, None, hidden_words(between, reason)))
    return _between((model, other), between, limits, noise, plan, progress)


def _between(
    pair: tuple[Explained, Explained],
    between: tuple[tuple[str, str], ...],
    limits: Limits,
    noise: Noise,
    plan: Plan,
    progress: Progress,
) -> Planned:
    found = design(pair, limits, noise, plan.duration, seed=plan.seed, evaluations=plan.evaluations, progress=progress)
    why = separation_words(found, between, plan.duration, limits.assumed)
    told = NextExperiment(between, found.separation, None, why)
    motion = None if found.separation == 0.0 else _sampled(found.point, pair, limits, plan)
    return Planned(told, limits, motion, design=found)


def _sampled(point: Array, models: tuple[Explained, ...], limits: Limits, plan: Plan) -> Motion | None:
    return feasible(Family(limits, plan.duration), point, models, round(plan.duration * plan.rate) + 1)


def _visited(seen: Observation, bench: Workbench) -> Visited:
    return visited(seen.q, seen.qd, seen.qdd, bench.effort)


def _differing(first: Robot, second: Robot) -> tuple[tuple[str, str], ...]:
    """What each of two models has that the other lacks; "" for nothing."""
    only = difference(first, second)
    return tuple((effects[0].type, effects[0].at) if effects else ("", "") for effects in only)


def _question(diagnosis: Diagnosis) -> tuple[Robot, Robot | None, tuple[tuple[str, str], ...]] | None:
    """(the diagnosed robot, its rival, what they differ in) for the first finding that leaves a question."""
    robot = diagnosis.diagnosed
    for finding in diagnosis.findings:
        # A sensor that is off, or gravity, is no force at a joint that a model could be given instead.
        forces = {finding.effect, *(name for name, law in catalogue().items() if law.proposable)}
        others = [other for other in finding.others if other[0] in forces]
        if others:
            rival = _exchanged(robot, (finding.effect, finding.place), others[0])
            return robot, rival, ((finding.effect, finding.place), others[0])
    for finding in diagnosis.findings:
        if any(finding.parameters[name].se is None for name in _can_be_told(finding)):
            return robot, None, ()
    return None


def _can_be_told(finding: Finding) -> list[str]:
    """Its parameters, but for those that no motion would tell, and that were assumed."""
    if finding.effect not in catalogue():
        return []  # gravity, or a transmission taken for rigid
    schemas = catalogue()[finding.effect].parameters
    assumed = {schema.name for schema in schemas if schema.is_count or schema.scan is Scan.ASSUMED}
    return [name for name in finding.parameters if name not in assumed]


def _exchanged(robot: Robot, old: tuple[str, str], new: tuple[str, str]) -> Robot:
    """The robot with one effect, and what corrects it, taken out, and another put in at its null value."""
    gone = {e.type for e in robot.effects if catalogue()[e.type].builds_on == old[0] and e.at == old[1]} | {old[0]}
    effects = [e for e in robot.effects if not (e.at == old[1] and e.type in gone)]
    parameters = list(robot.parameters)
    taken = {parameter.name for parameter in parameters}
    place = next(place for place in places(robot) if place.address == new[1])
    values = []
    for schema in catalogue()[new[0]].parameters:
        name = f"{new[1].replace('.', '_')}_{new[0]}_{schema.name}"
        while name in taken:
            name += "_"
        if schema.is_count:
            values.append((schema.name, Monomial(Fraction(schema.tried[0]), ())))
            continue
        null = 1.0 if schema.null is None else schema.null
        parameters.append(Parameter(name, null, schema.units[place.motion], schema.latex, schema.meaning))
        values.append((schema.name, Monomial(Fraction(1), ((name, 1),))))
    return replace(robot, effects=(*effects, EffectSpec(new[0], new[1], tuple(values))), parameters=tuple(parameters))
