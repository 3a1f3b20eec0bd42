"""Diagnosis of a machine of which only part is measured: locate, hypothesise, fit, judge, and write it down."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

from symdyn.numeric.candidates import held_parameters
from symdyn.numeric.filtering.afresh import afresh, astray, relieved, two_afresh, unburdened
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.budget import ENOUGH, Budget, allowed, within
from symdyn.numeric.filtering.conclude import conclude, parameters
from symdyn.numeric.filtering.contact import loosened
from symdyn.numeric.filtering.discretisation import with_discretisation
from symdyn.numeric.filtering.elsewhere import with_elsewhere
from symdyn.numeric.filtering.explain import sampled, step, without_effect
from symdyn.numeric.filtering.hypotheses import free_parameters
from symdyn.numeric.filtering.judged import Explanation, certain, earns, explained, tells_all
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.locate import Place, alone, locate
from symdyn.numeric.filtering.memory import lasting
from symdyn.numeric.filtering.model import Model, carried, holding, prepare, without_latent
from symdyn.numeric.filtering.one_law import in_one_law
from symdyn.numeric.filtering.propose import (
    as_fitted,
    of_structure,
    or_beneath_a_force,
    promises_most,
    restructured,
    stiffened,
)
from symdyn.numeric.filtering.reach import with_reach
from symdyn.numeric.filtering.refused import both, fitted_anew, reconsidered
from symdyn.numeric.filtering.remembering import Laws, laws_with_memory, suffice
from symdyn.numeric.filtering.signals import stretch
from symdyn.numeric.filtering.simpler import simpler
from symdyn.numeric.filtering.telling import finding
from symdyn.numeric.filtering.wider import widened
from symdyn.numeric.findings import Diagnosis, Finding
from symdyn.numeric.recording import Recording
from symdyn.numeric.verdict import NEGLIGIBLE
from symdyn.spec.records import Robot

Progress = Callable[[str], None]

MAX_FINDINGS = 6
LITTLE = 0.02  # of the error of the model as given: what laws that were found are off by themselves, where they turn
FEW = 100  # samples that need every function of a kernel
NEEDED = 5.0  # nats that an earlier finding must still bring beside the later ones


def diagnose_hidden(
    robot: Robot,
    training: Recording,
    heldout: Recording,
    progress: Progress,
    hold: Sequence[str] = (),
    thorough: bool = False,
) -> Diagnosis:
    """Explain what the model lacks, by the innovations of a Kalman filter on its emitted equations.

    Unless ``thorough``, the search ends when it has spent its budget; an alarm says what was not asked, then.
    Raises InputError (SD520, SD521) when an input of the model was not recorded, or nothing that answers to it;
    UsageError (SD010) when ``hold`` names a parameter that no fit moves.
    """
    with within(Budget(math.inf if thorough else ENOUGH)) as budget:
        found = _diagnosed(robot, training, heldout, progress, hold)
    if not budget.not_asked:
        return found
    told = f"the search ended early, and did not ask: {', '.join(budget.not_asked)}. With --thorough it asks everything"
    return replace(found, alarms=(*found.alarms, told))


def _diagnosed(
    robot: Robot, training: Recording, heldout: Recording, progress: Progress, hold: Sequence[str]
) -> Diagnosis:
    held = held_parameters(robot, free_parameters(robot), hold)
    progress(f"deriving and compiling {robot.name}")
    bare = holding(_compiled(robot, training, heldout, only=("",)), held)
    with ThreadPoolExecutor(1) as beside:  # a kernel with every hypothesis takes as long as the first fits without any
        compiled = beside.submit(_compiled, robot, training, heldout)
        given, places = _as_given(bare, progress)
        progress(f"deriving and compiling {robot.name} with every hypothesis")
        model = holding(compiled.result(), held)
    p, bench = carried(model, given.fit.p, given.fit.bench)
    current = explained(model, (), model.beliefs, fit(bench, p, model.beliefs, most=0))
    findings: list[Finding] = []
    alarms: list[str] = []
    least = min(NEGLIGIBLE, LITTLE * given.heldout)
    for _ in range(MAX_FINDINGS):
        model, current, findings = _searched(model, current, findings, alarms, least, (training, heldout), progress)
        current, findings, merged = in_one_law(model, current, findings, progress)
        if not merged:
            break
    told = {c.label for c, _ in current.found}
    alarms = [a for a in alarms if not any(a.startswith(f"{label} ") for label in told)]
    current, findings = _simplified(model, current, findings, progress)
    current, findings = _reexamined(model, current, findings, alarms)
    findings = [with_elsewhere(model, current, each) for each in findings]
    return conclude(model, bare, robot, places, given, current, findings, alarms, (training.name, heldout.name))


def _searched(
    model: Model,
    current: Explanation,
    findings: list[Finding],
    alarms: list[str],
    least: float,
    recordings: tuple[Recording, Recording],
    progress: Progress,
) -> tuple[Model, Explanation, list[Finding]]:
    """Effect after effect, until none earns its place any more, or free runs are off by ``least`` at most."""
    asked, begun = None, None
    while len(findings) < MAX_FINDINGS and current.heldout > least and allowed("what else is missing"):
        doubt = not tells_all(model, current)
        current = sampled(model, current) if doubt else current
        remembering = lasting(model, current) if doubt else ()
        rival = max((each.beyond for each in remembering), default=0.0)
        best, tried = step(model, current, alarms, progress, rival, doubt)
        best, tried = unburdened(model, current, best, tried, alarms)
        wider = None
        if doubt and current.found != asked:
            wider = widened(model, current, best, findings, recordings, progress)
        if wider is not None:
            model, current, findings = wider
            continue
        laws: Laws = ()
        if current.found != asked and promises_most(model, current, best, remembering):
            laws = laws_with_memory(model, current, best, remembering, recordings, progress)
            remembering = ()
        search, refused = doubt and not suffice(laws), None
        if search and best is not None:
            best, tried, refused = fitted_anew(model, current, best, tried, progress)
        if current.found != asked and search:  # begun with the model as given, whatever was fitted meanwhile
            best, tried = loosened(model, current, best, tried, alarms, progress)
        asked = current.found
        pair = None
        if search and best is not None:
            best, pair = reconsidered(model, current, best, tried, refused, progress)
        elif search:
            pair = both(model, current, tried, progress)
        if best is None and pair is None and search:
            again = relieved(model, current, progress) if current.found != begun else None
            begun = current.found  # it would begin there again
            if again is not None:
                current = again
                continue
            best, more = afresh(model, current, alarms, progress)
            tried = (*tried, *more)
            pair = None if best else two_afresh(model, current, more, progress)
        so_far = replace(pair[1], gain=current.fit.loss - pair[1].after.fit.loss) if pair else best
        change = restructured(model, current, so_far, laws, remembering, recordings, progress)
        if so_far is None and search:
            change = or_beneath_a_force(change, model, current, recordings, progress)
        if change is not None:
            model, current, new = change.model, change.after, change.finding
            if astray(model, current):
                current, begun = relieved(model, current, progress) or current, current.found
            asked = None  # there may be play where a part is new
            findings = [*(f for f in findings if change.keeps(f)), replace(new, heldout_after=current.heldout)]
        elif pair is not None:
            findings.append(finding(model, current, pair[0], pair))
            findings.append(finding(model, pair[0].after, pair[1], pair))
            current = pair[1].after
        elif best is not None:
            new = finding(model, current, best, tried)
            current = best.after
            if astray(model, current):
                current, begun = relieved(model, current, progress) or current, current.found
            findings.append(replace(new, heldout_after=current.heldout))
        else:
            break
        progress(f"found: {findings[-1].title} at {findings[-1].place}")
        model, current, findings = stiffened(model, current, findings, alarms, recordings, progress)
    return model, current, findings


def _compiled(robot: Robot, training: Recording, heldout: Recording, only: Sequence[str] = ()) -> Model:
    """The machine with hypotheses (``prepare``); its functions, which are compiled at their first use, have been."""
    model = prepare(robot, training, heldout, only=only)
    bench = model.bench(stretch(model.training, FEW), without_latent(model, model.training), Between.STRAIGHT)
    bench.filtered(model.values, tuple(model.beliefs))
    return model


def _as_given(model: Model, progress: Progress) -> tuple[Explanation, tuple[Place, ...]]:
    """The model without any effect that is found, and where an unknown force would help it, best first.

    No force is asked for where the model leaves nothing but noise.
    """
    first = alone(model, progress)
    given = explained(model, (), model.beliefs, first)
    if tells_all(model, given):
        return explained(model, (), model.beliefs, fit(first.bench, first.p, model.beliefs)), ()
    none, places = locate(model, first, progress)
    start = places[0].fit if places[0].gain > 0.0 else none
    return explained(model, (), model.beliefs, start), places


def _simplified(
    model: Model, current: Explanation, findings: list[Finding], progress: Progress
) -> tuple[Explanation, list[Finding]]:
    """With a simpler law in the place of one that tells no more."""
    for item in current.found:
        instead = simpler(model, current, item, progress)
        if instead is None:
            continue
        without, chosen = instead
        progress(f"as good as {item[0].label}: {chosen.score.candidate.title}")
        wide, current = (item[0].effect, item[0].place.address), chosen.after
        new = finding(model, without, chosen, (chosen,))
        findings = [new if (f.effect, f.place) == wide else f for f in findings]
    return current, findings


def _reexamined(
    model: Model, current: Explanation, findings: list[Finding], alarms: list[str]
) -> tuple[Explanation, list[Finding]]:
    """Findings that the others made needless are taken out again; the rest get their final values."""
    found = current.found
    sure = bool(found) and certain(model, current, found[-1][0])  # all that was fitted since may have made it nothing
    for item in found[:-1] if sure else found:
        candidate = item[0]
        if any(c.builds_on == candidate.effect and c.place == candidate.place for c, _ in current.found):
            continue
        without = without_effect(model, current, item)
        if without.fit.loss - current.fit.loss < NEEDED or not earns(model, without, current, candidate):
            alarms.append(f"{candidate.label} was taken out again: the others explain as much without it")
            current = without
    current = replace(current, fit=with_reach(with_discretisation(current.fit), _told(model, current)))
    kept = {(c.effect, c.place.address): c for c, _ in current.found}
    return current, [
        as_fitted(model, current, f)
        if of_structure(model, f)
        else replace(f, parameters=parameters(model, current, kept[f.effect, f.place]))
        for f in findings
        if (f.effect, f.place) in kept or of_structure(model, f)
    ]


def _told(model: Model, current: Explanation) -> list[str]:
    """Parameters of effects that were found, and of parts that the machine got."""
    of_effects = [c.parameter(schema) for c, _ in current.found for schema in (*c.linear, *c.shapes)]
    of_parts = [name for new in model.freed for name in (new.stiffness, new.damping)]
    return [*of_effects, *of_parts, *(sensor.name for sensor in model.lagging)]
