"""Friction that remembers its motion or its heat: where it would explain what is left."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.explain import remembered
from symdyn.numeric.filtering.hypotheses import HYSTERESIS, WARMING
from symdyn.numeric.filtering.judged import Explanation
from symdyn.numeric.filtering.locate import certainly_apart
from symdyn.numeric.filtering.model import Model
from symdyn.numeric.filtering.places import Latent
from symdyn.numeric.filtering.score import Left, whitened
from symdyn.numeric.filtering.signals import Signals
from symdyn.numeric.filtering.stiff import unseen_shafts
from symdyn.numeric.hybrid.compiled import compiled
from symdyn.physics import catalogue
from symdyn.spec.effect_schema import Scan

Array = NDArray[np.float64]

YIELDS = np.geomspace(1e-4, 0.5, 10)  # distances within which friction builds up, of the travel
_WARM = catalogue()["warm_up_friction"]
LEAST = 1e-12  # squared speed, over time, of what stands


@dataclass(frozen=True, slots=True)
class Lasting:
    """Friction that remembers, at a place: what it would gain (nats), its size, and how it remembers.

    ``shape`` of hysteresis is the distance within which it builds up; of friction that warms up its heat capacity and
    thermal resistance, the one per coefficient and the other times it.
    """

    latent: Latent
    laws: Mapping[str, str]  # HYSTERESIS or WARMING
    gain: float
    beyond: float  # nats over the same friction without a memory
    level: float
    shape: tuple[float, ...]
    group: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Tried:
    latent: Latent
    shape: tuple[float, ...]
    gain: float
    level: float
    rest: Array  # (N m,) what is left, whitened


def lasting(model: Model, current: Explanation) -> tuple[Lasting, ...]:
    """A score test of Dahl's loop, and of viscous friction that warms up, at every place that shows, best first.

    Their forces depend on the motion alone, and that the filter has: no state is needed to test for them.
    """
    bench, p = current.fit.bench, current.fit.p
    n = len(bench.kernel.coordinates)
    states = bench.filtered(p).states
    left = Left.of(bench, p, tuple(current.beliefs))
    found: list[Lasting] = []
    unseen = unseen_shafts(model, current)
    moving = [latent for latent in model.latents if latent.motion.any() and latent.place not in unseen]
    there = {(c.place.address, c.effect) for c in remembered(current)}
    for laws in (HYSTERESIS, WARMING):
        tried: list[_Tried] = []
        for latent in moving:
            if any((latent.place, law) in there for law in laws):
                continue  # one law of a kind remembers for all of them
            x, v = states[:, :n] @ latent.motion, states[:, n : 2 * n] @ latent.motion
            forces = _loops(x) if laws is HYSTERESIS else _warming(v, bench.signals)
            tried += _tested(model, current, left, latent, forces)
        found += _best(tried, laws, bench.signals.y.shape[1])
    return tuple(sorted(found, key=lambda each: -each.gain))


def _tested(
    model: Model, current: Explanation, left: Left, latent: Latent, forces: Mapping[tuple[float, ...], Array]
) -> list[_Tried]:
    """One run of the filter for all ``forces`` (N,), which are by their shape."""
    pushes = np.flatnonzero(latent.direction)
    weights = [_mean(force) for force in forces.values()]
    names = tuple(model.kernel.parameters[i] for _ in weights for i in pushes)
    weight = np.column_stack([w for w in weights for _ in pushes])
    columns = whitened(current.fit.bench.filtered(current.fit.p, names, weight)).reshape(-1, len(weights), len(pushes))
    columns = columns @ latent.direction[pushes]
    found = []
    for i, shape in enumerate(forces):
        gain, height, rest = left.explained(columns[:, [i]], np.zeros(1), np.array([np.inf]))
        found.append(_Tried(latent, shape, gain, float(height[0]), rest))
    return found


def _best(tried: list[_Tried], laws: Mapping[str, str], count: int) -> list[Lasting]:
    """Of each place; the first shape of each has no memory."""
    plain = {t.latent.place: t.gain for t in reversed(tried)}
    best: dict[str, _Tried] = {}
    for each in sorted(tried, key=lambda t: -t.gain):
        best.setdefault(each.latent.place, each)
    samples = {place: -0.5 * (t.rest.reshape(-1, count) ** 2).sum(axis=1) for place, t in best.items()}
    found = []
    for place, t in best.items():
        same = tuple(other for other, own in samples.items() if not certainly_apart(samples[place], own))
        found.append(Lasting(t.latent, laws, t.gain, t.gain - plain[place], t.level, t.shape, same))
    return found


def _loops(x: Array) -> dict[tuple[float, ...], Array]:
    """Dahl's friction along a motion, relative to its level, by the distance within which it builds up."""
    return {(float(d),): _loop(x, float(d)) for d in YIELDS * float(np.ptp(x))}


def _warming(v: Array, signals: Signals) -> dict[tuple[float, ...], Array]:
    """Friction that warms up, relative to its coefficient when cold, by heat capacity and thermal resistance.

    The first never warms.
    """
    steps = np.nan_to_num(signals.steps)  # 0 where a run ends: the next one begins cold
    capacity, resistance = (next(p for p in _WARM.parameters if p.scan is s) for s in (Scan.HEAT, Scan.HEATING))
    scale = next(p for p in _WARM.parameters if p.scan is Scan.ASSUMED).tried[0]
    summed = max(float(np.sum(v**2 * steps)), LEAST)
    found: dict[tuple[float, ...], Array] = {(math.inf, 0.0): v}
    for c in capacity.tried[::-1]:
        for r in resistance.tried:
            shape = (summed / c, r * float(np.sum(steps)) / summed)
            found[shape] = v * np.exp(-_rise(v, steps, *shape, scale) / scale)
    return found


@compiled
def _loop(x: Array, distance: float) -> Array:
    """(N,) between -1 and 1: Dahl's friction along a motion, relative to its level."""
    w = np.zeros(len(x))
    for k in range(len(x) - 1):
        way = x[k + 1] - x[k]
        end = 1.0 if way > 0.0 else -1.0
        w[k + 1] = end + (w[k] - end) * np.exp(-abs(way) / distance)
    return w


@compiled
def _rise(v: Array, steps: Array, capacity: float, resistance: float, scale: float) -> Array:
    """(N,) temperature of friction that its own heat thins, both relative to its coefficient when cold."""
    rise = np.zeros(len(v))
    for k in range(len(v) - 1):
        if steps[k] == 0.0:
            continue
        steady = v[k] * v[k] * np.exp(-rise[k] / scale) * resistance
        rise[k + 1] = steady + (rise[k] - steady) * np.exp(-steps[k] / (capacity * resistance))
    return rise


def _mean(w: Array) -> Array:
    """Over the step after each sample."""
    return np.append(0.5 * (w[1:] + w[:-1]), w[-1])
