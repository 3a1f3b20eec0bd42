"""Laws of friction with a memory, each fitted in full on a machine that has its state."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.filtering.beliefs import untold
from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.explain import remembered
from symdyn.numeric.filtering.hypotheses import HYSTERESIS, WARMING, memories, without_memory
from symdyn.numeric.filtering.judged import Explanation, Found, Step, explained, heldout_p_value, price
from symdyn.numeric.filtering.likelihood import MLFit, fit
from symdyn.numeric.filtering.memory import YIELDS, Lasting
from symdyn.numeric.filtering.model import Model, carried, prepare
from symdyn.numeric.filtering.places import Latent, latent_at
from symdyn.numeric.filtering.score import Score
from symdyn.numeric.filtering.side_by_side import side_by_side
from symdyn.numeric.filtering.travel import travel
from symdyn.numeric.recording import Recording
from symdyn.physics import catalogue

Array = NDArray[np.float64]
Progress = Callable[[str], None]
Start = tuple[float, ...]

FEW = 5  # rounds of a fit from each start
SLOWEST, SLOW = 0.02, 0.15  # of the usual top speed: where the Stribeck speed of a fit starts
REACHED = 0.5  # of the travel: within so far a loop comes near its level, from one end of the motion to the other
DAHL, ROUND = 1.0, 0.7  # shapes of a loop: with an exponent of 1 the former is Dahl's own
SIMPLEST = "dahl_friction"  # of its kind: where it ends, the others begin
LOOP, BEYOND = "bouc_wen_hysteresis", "hardening_hysteresis"  # where the level of the one is beyond reach, the other


@dataclass(frozen=True, slots=True, eq=False)
class _Beside:
    """What laws of a group of places are fitted beside: ``kept`` of what was found, and no hypothesis but that."""

    model: Model
    current: Explanation
    kept: Found
    group: tuple[str, ...]
    expected: float  # nats
    speed: float
    least: float  # nats beyond its price; what a rough fit finds worth less is given up
    recordings: tuple[Recording, Recording]
    progress: Progress
    bare: FilterBench | None = None

    def compiled_with(self, law: Candidate) -> tuple[Model, Candidate]:
        self.progress(f"deriving and compiling {self.model.robot.name} with {law.label}")
        states = [c for c in remembered(self.current) if c in [item[0] for item in self.kept]]
        only = tuple(c.label for c, _ in self.kept) or ("",)
        return prepare(self.model.robot, *self.recordings, (*states, law), only), law

    def fitted(self, item: tuple[Model, Candidate], start: Start) -> tuple[Model, Step] | None:
        trial, law = item
        done = _fitted(trial, self.current, self.kept, law, start, self.speed, self.least, self.bare)
        if done is None:
            return None
        after = explained(trial, (*self.kept, (law, None)), done.beliefs, done)
        score = Score(law, None, self.expected, np.zeros(0), len(YIELDS))
        gain = self.current.fit.loss - done.loss
        return trial, Step(score, after, gain, heldout_p_value(self.current, after), self.group)


def with_memory(
    model: Model,
    current: Explanation,
    loop: Lasting,
    least: float,
    recordings: tuple[Recording, Recording],
    progress: Progress,
    bare: FilterBench | None = None,
) -> tuple[tuple[Model, Step], ...]:
    """Every law that remembers so at that place, fitted in full, best first (BIC).

    What a rough fit finds worth less than ``least``, in nats beyond its price, is given up; and so are all others with
    the simplest of its kind, whose states tell what a memory is worth. A fit begins with the noise of ``bare``, then,
    in which no unknown force does the law's work.
    """
    laws, beyond = _in_turn(memories(model.robot, loop.latent.place, loop.laws))
    if not laws:
        return ()
    contained = without_memory(loop.laws)
    kept = tuple(
        item
        for item in current.found
        if not (item[0].effect in contained and item[0].place.address == loop.latent.place)
    )
    speed = travel(current, loop.latent).usual
    beside = _Beside(model, current, kept, loop.group, loop.gain, speed, least, recordings, progress, bare)
    start: Start = (loop.level, *loop.shape)
    steps: list[tuple[Model, Step]] = []
    if laws[0].effect == SIMPLEST:
        first, laws = laws[0], laws[1:]
        own = beside.compiled_with(first)
        progress(f"fitting {first.label}")
        simplest = beside.fitted(own, start)
        if simplest is None:
            return ()
        steps.append(simplest)
        start = _where_it_ends(first, simplest[1].after.fit)
    steps += _side_by_side(beside, laws, start)
    return _by_worth((*steps, *_beyond_reach(beside, loop.latent, steps, beyond)))


def with_wider_law(
    model: Model,
    current: Explanation,
    simplest: Candidate,
    least: float,
    recordings: tuple[Recording, Recording],
    progress: Progress,
) -> tuple[tuple[Model, Step], ...]:
    """Laws that contain the simplest of their kind, in its place and from where it ended, best first (BIC).

    What is worth less than ``least`` more than ``current``, in nats beyond its own price, is given up.
    """
    at = simplest.place.address
    latent = latent_at(model.latents, at)
    if latent is None:  # the rotor there became one with its joint since
        return ()
    wider = {law: size for law, size in HYSTERESIS.items() if simplest.effect in catalogue()[law].generalises}
    kept = tuple(item for item in current.found if item[0] is not simplest)
    beside = _Beside(model, current, kept, (at,), 0.0, travel(current, latent).usual, least, recordings, progress)
    laws, beyond = _in_turn(memories(model.robot, at, wider))
    steps = _side_by_side(beside, laws, _where_it_ends(simplest, current.fit))
    return _by_worth((*steps, *_beyond_reach(beside, latent, steps, beyond)))


def with_every_hypothesis(
    model: Model, step: Step, recordings: tuple[Recording, Recording], progress: Progress
) -> tuple[Model, Explanation]:
    """The machine with the law that was found, and all else that may be missing beside it."""
    progress(f"deriving and compiling {model.robot.name} with every hypothesis and {step.score.candidate.label}")
    whole = prepare(model.robot, *recordings, remembered(step.after))
    whole = replace(whole, beliefs=model.beliefs, freed=model.freed, lagging=model.lagging)
    p, bench = carried(whole, step.after.fit.p, step.after.fit.bench)
    return whole, explained(whole, step.after.found, step.after.beliefs, fit(bench, p, step.after.beliefs, most=0))


def _side_by_side(beside: _Beside, laws: Iterable[Candidate], start: Start) -> list[tuple[Model, Step]]:
    trials = [beside.compiled_with(law) for law in laws]
    if trials:
        beside.progress(f"fitting {' and '.join(law.label for _, law in trials)}")
    steps = side_by_side(lambda item: beside.fitted(item, start), trials)
    return [step for step in steps if step is not None]


def _in_turn(laws: Sequence[Candidate]) -> tuple[list[Candidate], list[Candidate]]:
    """Those to begin with, and those that one of them may lead to."""
    return [law for law in laws if law.effect != BEYOND], [law for law in laws if law.effect == BEYOND]


def _beyond_reach(
    beside: _Beside, latent: Latent, steps: Sequence[tuple[Model, Step]], beyond: Sequence[Candidate]
) -> list[tuple[Model, Step]]:
    """Loops without a level, where the fit of one with a level put it where the motion hardly comes."""
    ends = [end for _, step in steps if (end := _end(step.score.candidate, step.after.fit))]
    level, distance, shape = max(ends, key=lambda end: end[1], default=(0.0, 0.0, 0.0))
    width = travel(beside.current, latent).width
    if not ends or distance < REACHED * width:
        return []
    # As stiff there, and as far apart on both ways; the level is on the other side of infinity.
    return _side_by_side(beside, beyond, (level / distance, 0.5 * width, 1.0 + shape * width / distance))


def _end(law: Candidate, of: MLFit) -> tuple[float, float, float] | None:
    """Where a loop of exponent 1 ends: level, displacement, shape."""
    if law.effect == SIMPLEST:
        level, distance = _where_it_ends(law, of)
        return level, distance, DAHL
    if law.effect != LOOP or dict(law.counts)["exponent"] != 1.0:
        return None
    level, distance, shape = (
        float(of.p[of.bench.index[law.name_of(x)]]) for x in ("level", "yield_displacement", "shape")
    )
    return level, distance, shape


def _by_worth(steps: Iterable[tuple[Model, Step]]) -> tuple[tuple[Model, Step], ...]:
    return tuple(sorted(steps, key=lambda item: item[1].after.fit.loss + price(item[0], item[1].score.candidate)))


def _where_it_ends(simplest: Candidate, of: MLFit) -> Start:
    """Level, and distance within which friction builds up."""
    level, stiffness = (float(of.p[of.bench.index[simplest.name_of(x)]]) for x in ("level", "stiffness"))
    return level, level / stiffness


def _fitted(
    trial: Model,
    current: Explanation,
    kept: Found,
    law: Candidate,
    start: tuple[float, ...],
    speed: float,
    least: float,
    bare: FilterBench | None,
) -> MLFit | None:
    """None where the likeliest of a few rounds is worth less than ``least``."""
    p, bench = carried(trial, current.fit.p, current.fit.bench)
    gone = {
        c.parameter(s) for item in current.found if item not in kept for c in item[:1] for s in (*c.linear, *c.shapes)
    }
    others = {name: belief for name, belief in current.beliefs.items() if name not in gone}
    fits = []
    for values in _starts(law, start, speed):
        own = p.copy()
        beliefs = dict(others)
        for name, value in values.items():
            own[bench.index[law.name_of(name)]] = value
            beliefs[law.name_of(name)] = untold(value)
        if bare is not None:
            own = fit(carried(trial, current.fit.p, bare)[1], own, beliefs, most=FEW).p
        fits.append((fit(bench, own, beliefs, most=FEW), beliefs))
    first, beliefs = min(fits, key=lambda item: item[0].loss)
    if current.fit.loss - first.loss - price(trial, law) < least:
        return None
    return fit(first.bench, first.p, beliefs)


def _starts(law: Candidate, start: tuple[float, ...], speed: float) -> list[dict[str, float]]:
    """Where the fit of a law begins: by its size, and its shape."""
    if law.effect in WARMING:
        size, capacity, resistance = start
        return [{"coefficient": size, "heat_capacity": capacity * size, "thermal_resistance": resistance / size}]
    if law.effect == BEYOND:
        return [dict(zip(("stiffness", "displacement", "ratio"), start, strict=True))]
    level, distance = start
    if law.effect == SIMPLEST:
        return [{"stiffness": level / distance, "level": level}]
    if law.effect == LOOP:
        shapes = (DAHL,) if dict(law.counts)["exponent"] == 1.0 else (ROUND, DAHL)
        return [{"level": level, "yield_displacement": distance, "shape": shape} for shape in shapes]
    first = {"stiffness": level / distance, "damping": 0.1 * level / speed, "level": level, "excess": 0.3 * level}
    return [{**first, "stribeck_velocity": part * speed} for part in (SLOWEST, SLOW)]
