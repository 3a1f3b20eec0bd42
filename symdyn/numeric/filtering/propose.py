"""What changes a machine's structure, as no effect in its kernel can: the states that it lacks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from symdyn.numeric.filtering.budget import allowed
from symdyn.numeric.filtering.conclude import estimate, of_shaft
from symdyn.numeric.filtering.explain import covers, step
from symdyn.numeric.filtering.judged import (
    EARNS,
    LEVEL,
    WORTH,
    Explanation,
    Step,
    heldout_p_value,
    improves,
    nothing_left,
    price_of,
)
from symdyn.numeric.filtering.lag import late_sensors, with_lag
from symdyn.numeric.filtering.memory import Lasting, lasting
from symdyn.numeric.filtering.memory_fits import with_every_hypothesis
from symdyn.numeric.filtering.model import Freed, Model
from symdyn.numeric.filtering.remembering import (
    Laws,
    Recordings,
    laws_with_memory,
    likelier,
    promised,
    suffice,
)
from symdyn.numeric.filtering.stiff import beyond_sampling, resonance
from symdyn.numeric.filtering.structure import (
    EFFECT,
    TITLE,
    rigid_joints,
    with_shaft,
    without_shaft,
)
from symdyn.numeric.filtering.telling import finding, with_fixed_rotors
from symdyn.numeric.findings import Estimate, Finding
from symdyn.numeric.groups import same_place
from symdyn.physics import catalogue

Progress = Callable[[str], None]

NUMBERS = 2  # of a shaft


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


def promises_most(model: Model, current: Explanation, best: Step | None, remembering: Sequence[Lasting]) -> bool:
    """Whether a law with memory is expected to gain more than the best effect did, and than any sensor's lag."""
    most = promised(model, remembering)
    return most > (best.gain if best else 0.0) and all(most > each.gain for each in late_sensors(model, current))


def restructured(
    model: Model,
    current: Explanation,
    best: Step | None,
    laws: Laws,
    remembering: Sequence[Lasting],
    recordings: Recordings,
    progress: Progress,
) -> Change | None:
    """A law that remembers, or a transmission that is not rigid, where that explains more than any effect does.

    ``laws`` were fitted already; those of ``remembering`` are where none of them explains more than ``best``.
    """
    lagging = _lagging(model, current, best, recordings, progress)
    if lagging is not None:
        return lagging
    if nothing_left(model, best.after if best else current):
        return None
    tried = likelier(laws, current, best) or laws_with_memory(model, current, best, remembering, recordings, progress)
    if suffice(tried):
        return _with_law(model, current, tried, recordings, progress)
    owner, rival = tried[0] if tried else (model, best)
    freed = _freed(model, current, owner, rival, recordings, progress)
    if freed is None and tried:
        return _with_law(model, current, tried, recordings, progress)
    return freed


def or_beneath_a_force(
    change: Change | None, model: Model, current: Explanation, recordings: Recordings, progress: Progress
) -> Change | None:
    """A law that remembers where an unknown force does its work, if that is likelier than the change that was found.

    Beside the force no score promises such a law anything, and its fit stays where little of that work is its own.
    """
    if not covers(current) or (change is not None and nothing_left(change.model, change.after)):
        return change
    bench = current.fit.bench
    bare = bench.with_noise(bench.noise.quiet)
    found = lasting(model, replace(current, fit=replace(current.fit, bench=bare)))
    tried = laws_with_memory(model, current, None, found, recordings, progress, bare)
    if not tried or (change is not None and change.after.fit.loss <= tried[0][1].after.fit.loss):
        return change
    return _with_law(model, current, tried, recordings, progress)


def _lagging(
    model: Model, current: Explanation, best: Step | None, recordings: Recordings, progress: Progress
) -> Change | None:
    """A sensor that lags, where its own channel says so louder than any effect does."""
    found = late_sensors(model, current)
    least = max(WORTH + price_of(model, 1), best.gain if best else 0.0)
    if not found or found[0].gain < least:
        return None
    late = found[0].sensor
    slow, after = with_lag(model, current, found[0], recordings, progress)
    gain, p_value = current.fit.loss - after.fit.loss, heldout_p_value(current, after)
    if gain < least or p_value >= LEVEL:
        return None
    title, values = f"lag of a {catalogue()[late.type].title}", _values(slow, after, late.type, late.at)
    told = Finding(
        late.type, title, late.at, values, current.heldout, after.heldout, p_value, (), evidence=gain,
        group=with_fixed_rotors(model, (late.at,), late.type),
    )  # fmt: skip
    return Change(slow, after, told)


def _with_law(model: Model, current: Explanation, laws: Laws, recordings: Recordings, progress: Progress) -> Change:
    """The machine with the first of those laws."""
    own, chosen = laws[0]
    whole, after = with_every_hypothesis(model, chosen, recordings, progress)
    return Change(whole, after, finding(own, current, chosen, tuple(each for _, each in laws)))


def _freed(
    model: Model, current: Explanation, owner: Model, best: Step | None, recordings: Recordings, progress: Progress
) -> Change | None:
    """``owner`` is the model that ``best`` was fitted with."""
    for joint in rigid_joints(model.robot):
        if not allowed(f"a shaft that twists at {joint}"):
            break
        flexible, after = with_shaft(model.robot, joint, model.freed, model.lagging, current, recordings, progress)
        gain = current.fit.loss - after.fit.loss
        least = WORTH + price_of(model, NUMBERS)
        if gain < max(least, best.gain if best else 0.0) or after.heldout > (1.0 - EARNS) * current.heldout:
            continue
        if _too_fast(flexible, flexible.freed[-1], after):
            continue
        if best is not None and _two_tell_more(model, owner, best, after, recordings, progress):
            return None
        new = flexible.freed[-1]
        values = _values(flexible, after, EFFECT, joint.name)
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
        least = WORTH + price_of(model, NUMBERS)
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
    return with_fixed_rotors(model, tuple(dict.fromkeys((*of.group, *joints))), of.effect)


def _two_tell_more(
    model: Model, owner: Model, best: Step, flexible: Explanation, recordings: Recordings, progress: Progress
) -> bool:
    """Whether the likeliest effect and another one beside it explain more than a shaft, which has two numbers, too.

    ``owner``, a machine with a law of its own, has no hypothesis beside it.
    """
    beside, first = (model, best.after) if owner is model else with_every_hypothesis(model, best, recordings, progress)
    second, _ = step(beside, first, [], progress)
    return second is not None and second.after.fit.loss < flexible.fit.loss


def as_fitted(model: Model, of: Explanation, finding: Finding) -> Finding:
    """The finding of a part that the machine got, with the values that it has now."""
    return replace(finding, parameters=_values(model, of, finding.effect, finding.place))


def _values(model: Model, of: Explanation, effect: str, at: str) -> dict[str, Estimate]:
    """Parameters of a shaft that was freed, or of a sensor that got a lag."""
    for new in model.freed:
        if (effect, at) == (EFFECT, new.joint):
            return of_shaft(model, of, new)
    sensor = next(e for e in model.robot.effects if (e.type, e.at) == (effect, at))
    return {name: estimate(model, of.fit, value.factors[0][0]) for name, value in sensor.values if value.factors}


def of_structure(model: Model, of: Finding) -> bool:
    """Whether a finding is none of an effect that was added, but of a part that the machine got."""
    return of.effect == EFFECT or (of.effect, of.place) in {(x.effect, x.at) for x in model.lagging}
