"""Diagnosis of a machine of which only part is measured: locate, hypothesise, fit, judge, and write it down."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from symdyn.numeric.filtering.conclude import conclude, parameters
from symdyn.numeric.filtering.explain import Explanation, Step, alike, explained, step, without_effect
from symdyn.numeric.filtering.locate import locate
from symdyn.numeric.filtering.model import Model, prepare
from symdyn.numeric.findings import Alternative, Diagnosis, Finding, Rival
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
        if best is None:
            break
        findings.append(_finding(model, current, best, tried))
        current = best.after
        progress(f"found: {findings[-1].title} at {findings[-1].place}")
    current, findings = _reexamined(model, current, findings, alarms)
    return conclude(model, robot, places, given, current, findings, alarms, (training.name, heldout.name))


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
        (candidate.place.address, *elsewhere),
        chosen.gain,
    )


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
        replace(f, parameters=parameters(model, current, kept[f.effect, f.place]))
        for f in findings
        if (f.effect, f.place) in kept
    ]
