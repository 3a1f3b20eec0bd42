"""Diagnosis of a machine of which only part is measured: locate, hypothesise, fit, judge, and write it down."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from symdyn.numeric.filtering.conclude import conclude, estimate, noise_floor, parameters
from symdyn.numeric.filtering.explain import (
    ABOUT,
    EARNS,
    LEVEL,
    WORTH,
    Explanation,
    Step,
    alike,
    explained,
    heldout_p_value,
    step,
    without_effect,
)
from symdyn.numeric.filtering.locate import locate
from symdyn.numeric.filtering.model import Model, prepare
from symdyn.numeric.filtering.structure import EFFECT, TITLE, rigid_joints, with_shaft
from symdyn.numeric.findings import Alternative, Diagnosis, Finding, Rival
from symdyn.numeric.groups import rigid_group
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Robot

Progress = Callable[[str], None]

MAX_FINDINGS = 6
NEEDED = 5.0  # nats that an earlier finding must still bring beside the later ones


def diagnose_hidden(robot: Robot, training: Recording, heldout: Recording, progress: Progress) -> Diagnosis:
    """Explain what the model lacks, by the innovations of a Kalman filter on its emitted equations.

    Raises InputError (SD520, SD521) when an input of the model was not recorded, or nothing that answers to it.
    """
    progress(f"deriving and compiling {robot.name} with every hypothesis")
    model = prepare(robot, training, heldout)
    none, places = locate(model, progress)
    start = places[0].fit if places and places[0].gain > 0.0 else none
    given = current = explained(model, (), model.beliefs, start)
    findings: list[Finding] = []
    alarms: list[str] = []
    while len(findings) < MAX_FINDINGS:
        best, tried = step(model, current, alarms, progress)
        freed = _freed(robot, model, current, best, (training, heldout), progress)
        if freed is not None:
            model, after, finding = freed
            findings.append(finding)
            current = after
            continue
        if best is None:
            break
        findings.append(_finding(model, current, best, tried))
        current = best.after
        progress(f"found: {findings[-1].title} at {findings[-1].place}")
    current, findings = _reexamined(model, current, findings, alarms)
    return conclude(model, robot, places, given, current, findings, alarms, (training.name, heldout.name))


def _freed(
    robot: Robot,
    model: Model,
    current: Explanation,
    best: Step | None,
    recordings: tuple[Recording, Recording],
    progress: Progress,
) -> tuple[Model, Explanation, Finding] | None:
    """A transmission that is not rigid, where that explains more than any effect does."""
    so_far = best.after if best else current
    if so_far.heldout < (1.0 + ABOUT) * noise_floor(model, so_far.fit).errors.heldout:
        return None  # nothing is left but the noise of the sensors
    for joint in rigid_joints(model.robot):
        flexible, after = with_shaft(model.robot, joint, model.freed, current, recordings, progress)
        gain = current.fit.loss - after.fit.loss
        least = WORTH + float(np.log(len(model.training.y)))
        if gain < max(least, best.gain if best else 0.0) or after.heldout > (1.0 - EARNS) * current.heldout:
            continue
        new = flexible.freed[-1]
        values = {k: estimate(flexible, after.fit, getattr(new, k)) for k in ("stiffness", "damping")}
        p_value = heldout_p_value(current, after)
        finding = Finding(
            EFFECT, TITLE, joint.name, values, current.heldout, after.heldout, p_value, (), evidence=gain,
            group=(joint.name, f"{joint.name}.{new.rotor}", f"{joint.name}.{new.shaft}"),
        )  # fmt: skip
        if p_value < LEVEL:
            return flexible, after, finding
    return None


def _finding(model: Model, before: Explanation, chosen: Step, tried: tuple[Step, ...]) -> Finding:
    candidate = chosen.score.candidate
    same = alike(chosen, tried)
    elsewhere = [s.score.candidate.place.address for s in same if s.score.candidate.effect == candidate.effect]
    rivals = tuple(
        Rival(s.score.candidate.effect, s.score.candidate.place.address, s.p_value)
        for s in same
        if s.score.candidate.effect != candidate.effect
    )
    others = tuple(
        Alternative(s.score.candidate.effect, s.score.candidate.place.address, s.after.heldout)
        for s in tried
        if s is not chosen and s not in same
    )
    return Finding(
        candidate.effect,
        candidate.title,
        candidate.place.address,
        parameters(model, chosen.after, candidate),
        before.heldout,
        chosen.after.heldout,
        chosen.p_value,
        rivals,
        others,
        _with_fixed_rotors(model, (candidate.place.address, *elsewhere), candidate.effect),
        chosen.gain,
    )


def _with_fixed_rotors(model: Model, places: tuple[str, ...], effect: str) -> tuple[str, ...]:
    """A rotor that is fixed to its joint is one place with it."""
    found = list(places)
    for joint in model.robot.joints:
        fixed = {f"{joint.name}.{r.name}" for r in (joint.drive.rotors if joint.drive else ()) if r.fixed_to_joint}
        if joint.name in places:
            found += [place for place in rigid_group(joint, effect) if place in fixed]
    return tuple(found)


def _reexamined(
    model: Model, current: Explanation, findings: list[Finding], alarms: list[str]
) -> tuple[Explanation, list[Finding]]:
    """Earlier findings that later ones made needless are taken out again; the rest get their final values."""
    for item in current.found[:-1]:
        candidate = item[0]
        if any(c.builds_on == candidate.effect and c.place == candidate.place for c, _ in current.found):
            continue
        without = without_effect(model, current, item)
        if without.fit.loss - current.fit.loss < NEEDED:
            alarms.append(f"{candidate.label} was taken out again: later findings explain it better")
            current = without
    kept = {(c.effect, c.place.address): c for c, _ in current.found}
    return current, [
        replace(f, parameters=parameters(model, current, kept[f.effect, f.place])) if f.effect != EFFECT else f
        for f in findings
        if (f.effect, f.place) in kept or f.effect == EFFECT
    ]
