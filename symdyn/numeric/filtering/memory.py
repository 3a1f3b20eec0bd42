"""Friction and hysteresis that remember: where they would explain what is left, and the machine with their state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.filtering.beliefs import Beliefs, untold
from symdyn.numeric.filtering.explain import (
    Explanation,
    Found,
    Step,
    explained,
    heldout_p_value,
    price,
    remembered,
)
from symdyn.numeric.filtering.hypotheses import memories, without_memory
from symdyn.numeric.filtering.likelihood import MLFit, fit
from symdyn.numeric.filtering.locate import certainly_apart
from symdyn.numeric.filtering.model import Model, carried, prepare
from symdyn.numeric.filtering.places import Latent
from symdyn.numeric.filtering.score import Left, Score, whitened
from symdyn.numeric.hybrid.compiled import compiled
from symdyn.numeric.recording import Recording

Array = NDArray[np.float64]

YIELDS = np.geomspace(1e-4, 0.5, 10)  # distances within which friction builds up, of the travel
FEW = 5  # rounds of a fit from each start
SLOWEST, SLOW = 0.02, 0.15  # of the usual top speed: where the Stribeck speed of a fit starts


@dataclass(frozen=True, slots=True)
class Loop:
    """Hysteresis at a place: what it would gain (nats), its height, the distance within which it builds up."""

    latent: Latent
    gain: float
    beyond: float  # nats over friction that jumps, which is a loop of no distance
    level: float
    distance: float
    group: tuple[str, ...]


def loops(model: Model, current: Explanation) -> tuple[Loop, ...]:
    """A score test of a loop of Dahl's at every place, best first; one run of the filter for all of them.

    Its force depends on the motion alone, and that the filter has: no state is needed to test for it.
    """
    bench, p = current.fit.bench, current.fit.p
    n = len(bench.kernel.coordinates)
    q = bench.filtered(p).states[:, :n]
    left = Left.of(bench, p, tuple(current.beliefs))
    tried: list[tuple[float, float, float, Latent, Array]] = []
    for latent in model.latents:
        if not latent.motion.any():
            continue
        x = q @ latent.motion
        distances = YIELDS * float(np.ptp(x))
        pushes = np.flatnonzero(latent.direction)
        weights = [_mean(_loop(x, d)) for d in distances]
        names = tuple(model.kernel.parameters[i] for _ in weights for i in pushes)
        weight = np.column_stack([w for w in weights for _ in pushes])
        columns = whitened(bench.filtered(p, names, weight)).reshape(-1, len(weights), len(pushes))
        columns = columns @ latent.direction[pushes]
        for i, distance in enumerate(distances):
            gain, height, rest = left.explained(columns[:, [i]], np.zeros(1), np.array([np.inf]))
            tried.append((gain, float(height[0]), float(distance), latent, rest))
    tried.sort(key=lambda item: -item[0])
    found: list[Loop] = []
    count = bench.signals.y.shape[1]
    samples = {latent.place: -0.5 * (rest.reshape(-1, count) ** 2).sum(axis=1) for *_, latent, rest in reversed(tried)}
    jumps = {latent.place: gain for gain, _, distance, latent, _ in sorted(tried, key=lambda item: -item[2])}
    for gain, level, distance, latent, _ in tried:
        if latent.place not in {loop.latent.place for loop in found}:
            own = samples[latent.place]
            same = tuple(place for place, other in samples.items() if not certainly_apart(own, other))
            found.append(Loop(latent, gain, gain - jumps[latent.place], level, distance, same))
    return tuple(found)


def with_memory(
    model: Model,
    current: Explanation,
    loop: Loop,
    recordings: tuple[Recording, Recording],
    progress: Callable[[str], None],
) -> tuple[tuple[Model, Step], ...]:
    """Every law that remembers at the place of a loop, fitted in full, best first (BIC)."""
    tried: list[tuple[Model, Step]] = []
    contained = without_memory()
    kept = tuple(
        item
        for item in current.found
        if not (item[0].effect in contained and item[0].place.address == loop.latent.place)
    )
    start = {"level": loop.level, "distance": loop.distance}
    speed = _top_speed(current, loop)
    for law in memories(model.robot, loop.latent.place):
        progress(f"deriving and compiling {model.robot.name} with {law.label}")
        trial = prepare(model.robot, *recordings, (*remembered(current), law), tuple(c.label for c, _ in kept) or ("",))
        done, beliefs = _fitted(trial, current, kept, law, start, speed)
        if law.effect == "dahl_friction":
            p, index = done.p, done.bench.index
            level = float(p[index[_name(law, "level")]])
            start = {"level": level, "distance": level / float(p[index[_name(law, "stiffness")]])}
        after = explained(trial, (*kept, (law, None)), beliefs, done)
        gain = current.fit.loss - done.loss
        score = Score(law, None, loop.gain, np.zeros(0), len(YIELDS))
        tried.append((trial, Step(score, after, gain, heldout_p_value(current, after), loop.group)))
    tried.sort(key=lambda item: item[1].after.fit.loss + price(model, item[1].score.candidate))
    return tuple(tried)


def with_every_hypothesis(
    model: Model, step: Step, recordings: tuple[Recording, Recording], progress: Callable[[str], None]
) -> tuple[Model, Explanation]:
    """The machine with the law that was found, and all else that may be missing beside it."""
    progress(f"deriving and compiling {model.robot.name} with every hypothesis and {step.score.candidate.label}")
    whole = prepare(model.robot, *recordings, remembered(step.after))
    whole = replace(whole, beliefs=model.beliefs, freed=model.freed, lagging=model.lagging)
    p, bench = carried(whole, step.after.fit.p, step.after.fit.bench)
    return whole, explained(whole, step.after.found, step.after.beliefs, fit(bench, p, step.after.beliefs))


def _fitted(
    trial: Model, current: Explanation, kept: Found, law: Candidate, start: dict[str, float], speed: float
) -> tuple[MLFit, Beliefs]:
    p, bench = carried(trial, current.fit.p, current.fit.bench)
    gone = {
        c.parameter(s) for item in current.found if item not in kept for c in item[:1] for s in (*c.linear, *c.shapes)
    }
    others = {name: belief for name, belief in current.beliefs.items() if name not in gone}
    fits = []
    for values in _starts(law, start["level"], start["distance"], speed):
        own = p.copy()
        beliefs = dict(others)
        for name, value in values.items():
            own[bench.index[_name(law, name)]] = value
            beliefs[_name(law, name)] = untold(value)
        fits.append((fit(bench, own, beliefs, most=FEW), beliefs))
    first, beliefs = min(fits, key=lambda item: item[0].loss)
    return fit(first.bench, first.p, beliefs), beliefs


def _starts(law: Candidate, level: float, distance: float, speed: float) -> list[dict[str, float]]:
    """Where the fit of a law begins: by the height of a loop, and the distance within which it builds up."""
    if law.effect == "dahl_friction":
        return [{"stiffness": level / distance, "level": level}]
    if law.effect == "bouc_wen_hysteresis":
        return [{"level": level, "yield_displacement": distance, "shape": shape} for shape in (0.7, 1.0)]
    first = {"stiffness": level / distance, "damping": 0.1 * level / speed, "level": level, "excess": 0.3 * level}
    return [{**first, "stribeck_velocity": part * speed} for part in (SLOWEST, SLOW)]


def _name(law: Candidate, parameter: str) -> str:
    return next(law.parameter(s) for s in (*law.linear, *law.shapes) if s.name == parameter)


def _top_speed(current: Explanation, loop: Loop) -> float:
    n = len(loop.latent.motion)
    states = current.fit.bench.filtered(current.fit.p).states
    return max(float(np.quantile(np.abs(states[:, n : 2 * n] @ loop.latent.motion), 0.95)), 1e-12)


@compiled
def _loop(x: Array, distance: float) -> Array:
    """(N,) between -1 and 1: Dahl's friction along a motion, relative to its level."""
    w = np.zeros(len(x))
    for k in range(len(x) - 1):
        way = x[k + 1] - x[k]
        end = 1.0 if way > 0.0 else -1.0
        w[k + 1] = end + (w[k] - end) * np.exp(-abs(way) / distance)
    return w


def _mean(w: Array) -> Array:
    """Over the step after each sample."""
    return np.append(0.5 * (w[1:] + w[:-1]), w[-1])
