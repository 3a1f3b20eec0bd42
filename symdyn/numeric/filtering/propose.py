"""What changes a machine's structure, as no effect in its kernel can: states that it lacks; how findings are told."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symdyn.numeric.filtering.conclude import estimate, parameters
from symdyn.numeric.filtering.explain import step
from symdyn.numeric.filtering.judged import (
    ABOUT,
    EARNS,
    LEVEL,
    WORTH,
    Explanation,
    Step,
    alike,
    certain,
    floor,
    heldout_p_value,
    improves,
    price,
    simplest,
)
from symdyn.numeric.filtering.lag import LAG, late_sensors, with_lag
from symdyn.numeric.filtering.memory import Lasting, with_every_hypothesis, with_memory
from symdyn.numeric.filtering.model import Freed, Model
from symdyn.numeric.filtering.places import same_place
from symdyn.numeric.filtering.stiff import beyond_sampling, resonance, rigid_with
from symdyn.numeric.filtering.structure import (
    EFFECT,
    TITLE,
    rigid_joints,
    with_shaft,
    without_shaft,
)
from symdyn.numeric.findings import Alternative, Finding, Rival
from symdyn.numeric.groups import rigid_group
from symdyn.numeric.recording import Recording
from symdyn.physics import catalogue

Progress = Callable[[str], None]
Recordings = tuple[Recording, Recording]

PLACES = 2  # of a group, at which laws that remember are fitted
LIKELY = 0.5  # of the best effect's expected gain: a loop that promises less is not worth a compilation


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """A machine with more states, fitted, and what is told of it."""

    model: Model
    after: Explanation
    finding: Finding

    def keeps(self, earlier: Finding) -> bool:
        """Whether an earlier finding is still part of the explanation."""
        return of_structure(self.model, earlier) or (earlier.effect, earlier.place) in {
            (c.effect, c.place.address) for c, _ in self.after.found
        }


def restructured(
    model: Model,
    current: Explanation,
    best: Step | None,
    remembering: Sequence[Lasting],
    recordings: Recordings,
    progress: Progress,
) -> Change | None:
    """A law that remembers, or a transmission that is not rigid, where that explains more than any effect does."""
    lagging = _lagging(model, current, best, recordings, progress)
    if lagging is not None:
        return lagging
    so_far = best.after if best else current
    if so_far.heldout < (1.0 + ABOUT) * floor(model, so_far):
        return None  # nothing is left but the noise of the sensors
    tried = _remembering(model, current, best, remembering, recordings, progress)
    if tried is not None:
        chosen = tried[0][1]
        if chosen.after.heldout < (1.0 + ABOUT) * floor(model, chosen.after):
            return _with_law(model, current, tried, recordings, progress)
    owner, rival = tried[0] if tried else (model, best)
    freed = _freed(model, current, owner, rival, recordings, progress)
    if freed is None and tried is not None:
        return _with_law(model, current, tried, recordings, progress)
    return freed


def _lagging(
    model: Model, current: Explanation, best: Step | None, recordings: Recordings, progress: Progress
) -> Change | None:
    """A sensor that lags, where its own channel says so louder than any effect does."""
    found = late_sensors(model, current)
    least = max(WORTH + 0.5 * float(np.log(len(model.training.y))), best.gain if best else 0.0)
    if not found or found[0].gain < least:
        return None
    late = found[0].sensor
    slow, after = with_lag(model, current, found[0], recordings, progress)
    gain, p_value = current.fit.loss - after.fit.loss, heldout_p_value(current, after)
    if gain < least or p_value >= LEVEL:
        return None
    values = {name: estimate(slow, after.fit, value.factors[0][0]) for name, value in late.values if value.factors}
    values[LAG] = estimate(slow, after.fit, slow.lagging[-1].parameter)
    title = f"lag of a {catalogue()[late.type].title}"
    told = Finding(
        late.type, title, late.at, values, current.heldout, after.heldout, p_value, (), evidence=gain,
        group=_with_fixed_rotors(model, (late.at,), late.type),
    )  # fmt: skip
    return Change(slow, after, told)


Tried = tuple[tuple[Model, Step], ...]


def _remembering(
    model: Model,
    current: Explanation,
    best: Step | None,
    found: Sequence[Lasting],
    recordings: Recordings,
    progress: Progress,
) -> Tried | None:
    least = WORTH + float(np.log(len(model.training.y)))
    places: dict[frozenset[str], list[Lasting]] = {}  # of each kind of memory the best, and those of its group
    for each in sorted(found, key=lambda x: -x.gain):
        here = places.setdefault(frozenset(each.laws), [])
        if not here or (len(here) < PLACES and each.latent.place in here[0].group):
            here.append(each)
    for each in sorted((x for here in places.values() for x in here), key=lambda x: -x.gain):
        if each.beyond < least or each.gain < (LIKELY * best.score.gain if best else 0.0):
            continue
        tried = with_memory(model, current, each, recordings, progress)
        good = [(trial, step) for trial, step in tried if _earns(trial, current, step, best)]
        if good:
            chosen = simplest(good[0][1], [step for _, step in good])
            return tuple(sorted(good, key=lambda each: each[1] is not chosen))
    return None


def _earns(model: Model, current: Explanation, each: Step, best: Step | None) -> bool:
    worth = each.gain - price(model, each.score.candidate)
    other = best.gain - price(model, best.score.candidate) if best else 0.0
    return (
        worth > WORTH + max(other, 0.0)
        and each.p_value < LEVEL
        and each.after.heldout < (1.0 - EARNS) * current.heldout
        and certain(model, each.after, each.score.candidate)
    )


def _with_law(model: Model, current: Explanation, tried: Tried, recordings: Recordings, progress: Progress) -> Change:
    chosen = tried[0][1]
    whole, after = with_every_hypothesis(model, chosen, recordings, progress)
    return Change(whole, after, finding(tried[0][0], current, chosen, tuple(each for _, each in tried)))


def _freed(
    model: Model, current: Explanation, owner: Model, best: Step | None, recordings: Recordings, progress: Progress
) -> Change | None:
    """``owner`` is the model that ``best`` was fitted with."""
    for joint in rigid_joints(model.robot):
        flexible, after = with_shaft(model.robot, joint, model.freed, model.lagging, current, recordings, progress)
        gain = current.fit.loss - after.fit.loss
        least = WORTH + float(np.log(len(model.training.y)))
        if gain < max(least, best.gain if best else 0.0) or after.heldout > (1.0 - EARNS) * current.heldout:
            continue
        if _too_fast(flexible, flexible.freed[-1], after):
            continue
        if _two_tell_more(owner, best, after, progress):
            return None
        new = flexible.freed[-1]
        values = {k: estimate(flexible, after.fit, getattr(new, k)) for k in ("stiffness", "damping")}
        p_value = heldout_p_value(current, after)
        told = Finding(
            EFFECT, TITLE, joint.name, values, current.heldout, after.heldout, p_value, (), evidence=gain,
            group=(joint.name, f"{joint.name}.{new.rotor}", f"{joint.name}.{new.shaft}"),
        )  # fmt: skip
        if p_value < LEVEL:
            return Change(flexible, after, told)
    return None


def _too_fast(model: Model, new: Freed, of: Explanation) -> bool:
    """Whether a shaft is as good as rigid at this sampling rate: it fits something else."""
    return beyond_sampling(model, resonance(model, of.fit, new.joint, f"{new.joint}.{new.rotor}"))


def stiffened(
    model: Model,
    current: Explanation,
    findings: Sequence[Finding],
    alarms: list[str],
    recordings: Recordings,
    progress: Progress,
) -> tuple[Model, Explanation, list[Finding]]:
    """Shafts that what was found after them explains are taken out again."""
    for new in model.freed:
        told = next(f for f in findings if (f.effect, f.place) == (EFFECT, new.joint))
        if told is findings[-1] or any(c.place.address == f"{new.joint}.{new.shaft}" for c, _ in current.found):
            continue
        rigid, without = without_shaft(model, new, current, recordings, progress)
        least = WORTH + float(np.log(len(model.training.y)))
        gain = without.fit.loss - current.fit.loss
        if gain > least and improves(without, current) and not _too_fast(model, new, current):
            continue
        alarms.append(f"{TITLE} at {new.joint} was taken out again: later findings explain it better")
        model, current = rigid, without
        findings = [replace(f, group=_fixed(model, f)) for f in findings if f is not told]
    return model, current, list(findings)


def _fixed(model: Model, of: Finding) -> tuple[str, ...]:
    """The places of a finding, where some have become one."""
    joints = (at for place in of.group for at in same_place(model.robot, place))
    return _with_fixed_rotors(model, tuple(dict.fromkeys((*of.group, *joints))), of.effect)


def _two_tell_more(model: Model, best: Step | None, flexible: Explanation, progress: Progress) -> bool:
    """Whether the likeliest effect and another one beside it explain more than a shaft, which has two numbers, too."""
    if best is None:
        return False
    second, _ = step(model, best.after, [], progress)
    return second is not None and second.after.fit.loss < flexible.fit.loss


def finding(model: Model, before: Explanation, chosen: Step, tried: tuple[Step, ...]) -> Finding:
    candidate = chosen.score.candidate
    own = candidate.effect, candidate.place.address
    tried = tuple(s for s in tried if (s.score.candidate.effect, s.score.candidate.place.address) != own)
    same = alike(chosen, tried)
    elsewhere = [s.score.candidate.place.address for s in same if s.score.candidate.effect == candidate.effect]
    elsewhere += rigid_with(model, chosen.after, candidate.place.address, candidate.effect)
    rivals = tuple(
        Rival(s.score.candidate.effect, s.score.candidate.place.address, s.p_value)
        for s in same
        if s.score.candidate.effect != candidate.effect
    )
    others = tuple(
        Alternative(s.score.candidate.effect, s.score.candidate.place.address, s.after.heldout)
        for s in tried
        if s not in same
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
        _with_fixed_rotors(model, (candidate.place.address, *elsewhere, *chosen.group), candidate.effect),
        chosen.gain,
    )


def of_structure(model: Model, of: Finding) -> bool:
    """Whether a finding is none of an effect that was added, but of a part that the machine got."""
    return of.effect == EFFECT or (of.effect, of.place) in {(x.effect, x.at) for x in model.lagging}


def _with_fixed_rotors(model: Model, places: tuple[str, ...], effect: str) -> tuple[str, ...]:
    """A rotor that is fixed to its joint is one place with it."""
    found = list(dict.fromkeys(places))
    for joint in model.robot.joints:
        fixed = {f"{joint.name}.{r.name}" for r in (joint.drive.rotors if joint.drive else ()) if r.fixed_to_joint}
        if joint.name in places:
            found += [place for place in rigid_group(joint, effect) if place in fixed]
    return tuple(found)
