"""The experiment command, and the experiment that a diagnosis asks for: a trajectory file, and why."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from symdyn import compiler
from symdyn.base.errors import Problem, UsageError
from symdyn.base.files import check_writable, write_atomically
from symdyn.base.wording import did_you_mean
from symdyn.faces.console import err, out, print_json, print_table, status
from symdyn.faces.model_commands import refuse_free_parameters
from symdyn.faces.recordings import open_recording
from symdyn.numeric.experiment.limits import Visited, check_names, experiment_limits, read_limits, visited
from symdyn.numeric.experiment.motions import Motion
from symdyn.numeric.experiment.next_experiment import (
    Given,
    Plan,
    Planned,
    after_diagnosis,
    between_models,
    for_parameters,
)
from symdyn.numeric.experiment.separation import Noise
from symdyn.numeric.findings import Diagnosis
from symdyn.numeric.observation import observe
from symdyn.numeric.recording import Recording
from symdyn.spec.records import JointKind, Robot
from symdyn.spec.urdf_chain import Chain

Array = NDArray[np.float64]

MOST_ROWS = 1_000_000


def run(
    model: str,
    rival: str | None,
    chain: Chain,
    noise: list[str],
    limits: list[str],
    recording: Path | None,
    channel_map: Path | None,
    band: float,
    duration: float,
    rate: float,
    seed: int,
    path: Path | None,
    json: bool,
) -> int:
    """Returns the exit code: 1 where no motion within the limits separates the two models."""
    plan = Plan(duration, rate, seed)
    check_plan(plan)
    if not (math.isfinite(band) and band > 0):
        raise UsageError(Problem("SD010", f"--band is a frequency in Hz above zero, not {band}"))
    if path is not None:
        check_writable(path)
    robots = [compiler.load_robot(text, chain) for text in (model, *((rival,) if rival else ()))]
    for robot in robots:
        refuse_free_parameters(robot)
    _same_joints(robots)
    robot = robots[0]
    floor = Noise(_noise(noise, robot), 2.0 * band)
    with status(json) as progress:
        seen = None if recording is None else _seen(robot, open_recording(recording, robot, channel_map))
        allowed = experiment_limits(robot, read_limits(limits), seen)
        if rival is None:
            planned = for_parameters(robot, allowed, floor, plan, progress)
        else:
            planned = between_models(robot, robots[1], allowed, floor, plan, progress)
    told = written(planned, robot, path)
    if json:
        print_json(facts(told, plan))
    else:
        out.print(told.told.why, markup=False)
        _print_tables(told)
        if told.told.file is not None:
            err.print(f"trajectory: {path}", markup=False)
    return 0 if rival is None or (told.design is not None and told.design.separates) else 1


def add_experiment(
    diagnosis: Diagnosis,
    training: Recording,
    limits: Given,
    plan: Plan,
    path: Path,
    progress: Callable[[str], None],
) -> Diagnosis:
    """The diagnosis with its next experiment, whose trajectory is written; unchanged where it left no question."""
    planned = after_diagnosis(diagnosis, training, limits, plan, progress)
    if planned is None:
        return diagnosis
    return replace(diagnosis, next_experiment=written(planned, diagnosis.robot, path).told)


def experiment_bounds(texts: Sequence[str], robot: Robot, path: Path | None) -> Given:
    """Limits by joint, checked before a diagnosis takes its time. Raises UsageError (SD330)."""
    if texts and path is None:
        hint = "add --experiment FILE to have one designed"
        raise UsageError(Problem("SD330", "--limits are those of an experiment, and none is asked for", hint=hint))
    given = read_limits(texts)
    check_names(given, robot)
    return given


def check_plan(plan: Plan) -> None:
    """Raises UsageError (SD302) for a duration or rate that is none."""
    for name, value in (("--duration", plan.duration), ("--rate", plan.rate)):
        if not (math.isfinite(value) and value > 0):
            raise UsageError(Problem("SD302", f"{name} must be positive"))
    if not 10 <= plan.duration * plan.rate <= MOST_ROWS or plan.seed < 0:
        message = f"--duration times --rate must be 10 to {MOST_ROWS} rows, --seed not negative"
        raise UsageError(Problem("SD302", message))


def written(planned: Planned, robot: Robot, path: Path | None) -> Planned:
    """The plan, with its trajectory written as CSV where there is one and a path is given."""
    columns = planned.columns
    if planned.motion is not None:
        columns = _of_motion(planned.motion, robot)
    if columns is None or path is None:
        return planned
    buffer = io.StringIO()
    pd.DataFrame(dict(columns)).to_csv(buffer, index=False, float_format="%.9g", lineterminator="\n")
    write_atomically(path, buffer.getvalue())
    return replace(planned, told=replace(planned.told, file=str(path)))


def _of_motion(motion: Motion, robot: Robot) -> Mapping[str, Array]:
    names = tuple(joint.name for joint in robot.joints)
    units = tuple("m" if joint.kind is JointKind.PRISMATIC else "rad" for joint in robot.joints)
    return motion.table(names, units)


def facts(planned: Planned, plan: Plan) -> dict[str, Any]:
    """The plan for other programs."""
    found = planned.told.to_json() | {"duration": plan.duration, "rate": plan.rate, "seed": plan.seed}
    if planned.design is not None:
        design = planned.design
        found |= {
            "separates": design.separates,
            "usual": design.usual,
            "directions": [{"truth": d.truth, "separation": d.nats, "nested": d.nested} for d in design.directions],
            "would": {"what": design.wider, "factor": design.factor} if design.wider else None,
        }
    if planned.identifying is not None:
        found |= {"separation": None, "standard_errors": planned.identifying.standard_errors}
        found |= {"gain": planned.identifying.gain}
    return found


def _print_tables(planned: Planned) -> None:
    if planned.identifying is not None:
        rows = [
            (name, "not by itself" if error is None else f"{error:.3g}")
            for name, error in planned.identifying.standard_errors.items()
        ]
        print_table("", ("parameter", "standard error to expect"), rows)


def _seen(robot: Robot, recording: Recording) -> Visited:
    kernel = compiler.compile_robot(robot).kernel()
    found = observe(robot, kernel, recording)
    return visited(found.q, found.qd, found.qdd, found.tau)


def _same_joints(robots: Sequence[Robot]) -> None:
    first, *others = ([joint.name for joint in robot.joints] for robot in robots)
    for other in others:
        if other != first:
            message = f"the models must have the same joints: {', '.join(first)} and {', '.join(other)}"
            raise UsageError(Problem("SD330", message))


def _noise(texts: Sequence[str], robot: Robot) -> Array:
    """(n,) from ``0.02`` for all joints or ``elbow=0.02`` for one."""
    names = [joint.name for joint in robot.joints]
    found = np.full(len(names), np.nan)
    for text in texts:
        name, equals, number = text.rpartition("=")
        if equals and name not in names:
            raise UsageError(Problem("SD330", f"--noise: no joint `{name}`", hint=did_you_mean(name, names, "joints")))
        try:
            value = float(number)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value > 0):
            raise UsageError(Problem("SD330", f"--noise {text}: an effort in SI units above zero is asked for"))
        found[names.index(name) if equals else slice(None)] = value
    if np.isnan(found).any():
        lacking = ", ".join(n for n, v in zip(names, found, strict=True) if np.isnan(v))
        hint = "--noise 0.02 for all joints (N m or N, r.m.s. in the band), --noise elbow=0.02 for one"
        raise UsageError(Problem("SD330", f"the noise of the effort is not given: {lacking}", hint=hint))
    return found
