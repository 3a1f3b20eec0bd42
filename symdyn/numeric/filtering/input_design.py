"""T-optimal inputs: those under which the wrong one of two explanations is off by most (Atkinson and Fedorov 1975)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from symdyn.numeric.experiment.design import SEPARATES, WIDER
from symdyn.numeric.experiment.searching import maximised
from symdyn.numeric.experiment.waveforms import brought_in, fourier_series, triangle
from symdyn.numeric.filtering.imagined import Explaining
from symdyn.numeric.filtering.side_by_side import side_by_side
from symdyn.numeric.filtering.signals import Signals
from symdyn.physics import catalogue

Array = NDArray[np.float64]
Progress = Callable[[str], None]
Pair = tuple[Explaining, Explaining]
Range = tuple[float, float, float]  # of a joint: lower, upper, top speed

HARMONICS = 5  # of the Fourier series
FASTEST = 0.02  # periods of its fundamental per sample, at most
MOST_SWEEPS = 20.0  # to and fro
LEAST_SHARE, MOST_SHARE = 0.1, 0.9  # of the time that the sweeps take
SHRINK, SHRINKINGS = 0.7, 14  # where the machine would leave its limits
POOL = 32  # inputs that are spread over all kinds: the median of what they promise is the usual
MEMBERS, EVALUATIONS = 12, 72  # of the search from the best of those
FEW = 7  # of those, which are tried with wider limits
NOTHING = 1e-6  # of what the other way promises: one law is held by the other


@dataclass(frozen=True, slots=True, eq=False)
class Inputs:
    """All inputs of ``count`` samples, ``step`` s apart, each a point of the unit cube of ``size`` dimensions.

    ``middle`` and ``reach`` (nu,) are of what was recorded. The first coordinate is the sweeps' share of the time, the
    second the fundamental of the series; then per input: height and rate of the sweeps, height of the series, and
    its coefficients.
    """

    middle: Array
    reach: Array
    count: int
    step: float

    @property
    def size(self) -> int:
        return 2 + len(self.middle) * (3 + 2 * HARMONICS)

    def signal(self, point: Array, scale: float = 1.0) -> Array:
        """(count, nu), never beyond what was recorded; ``scale`` shrinks it towards the middle."""
        time, duration = self.step * np.arange(self.count), self.step * self.count
        sweeping = (LEAST_SHARE + (MOST_SHARE - LEAST_SHARE) * point[0]) * duration
        rest = duration - sweeping
        frequency = max(1.0, FASTEST / self.step * rest) ** point[1] / rest
        first = time < sweeping
        u = np.zeros((self.count, len(self.middle)))
        per = 3 + 2 * HARMONICS
        for j, own in enumerate(point[2:].reshape(-1, per)):
            sweep = brought_in(triangle(time[first], MOST_SWEEPS ** own[1] / sweeping), time[first], sweeping)[0]
            waves = fourier_series(time[~first] - sweeping, frequency, own[3:].reshape(2, -1))
            series = brought_in(waves, time[~first] - sweeping, rest)[0]
            u[first, j] = own[0] * sweep / max(float(np.max(np.abs(sweep))), 1e-12)
            u[~first, j] = own[2] * series / max(float(np.max(np.abs(series))), 1e-12)
        return np.asarray(self.middle + scale * self.reach * u)


@dataclass(frozen=True, slots=True, eq=False)
class Contest:
    """Two explanations under all inputs of a family; ``ranges`` of the coordinates that have one, by their index."""

    pair: Pair
    inputs: Inputs
    ranges: Mapping[int, Range]

    def allowed(self, point: Array) -> Array | None:
        """The point's input, made smaller until both machines stay within their ranges; None where they never do."""
        for k in range(SHRINKINGS):
            u = self.inputs.signal(point, SHRINK**k)
            if all(self._within(each, each.shown(u)) for each in self.pair):
                return u
        return None

    def nats(self, point: Array) -> tuple[float, float]:
        """What the other one loses where the first is true, and where the second is."""
        u = self.allowed(point)
        if u is None:
            return 0.0, 0.0
        first, second = self.pair
        return second.lost(first.shown(u)), first.lost(second.shown(u))

    def wider(self, factor: float) -> Contest:
        """With so many times the reach of the inputs, and so wide ranges."""
        ranges = {
            i: (
                (lower + upper - factor * (upper - lower)) / 2, (lower + upper + factor * (upper - lower)) / 2,
                factor * speed,
            )
            for i, (lower, upper, speed) in self.ranges.items()
        }  # fmt: skip
        return replace(self, inputs=replace(self.inputs, reach=factor * self.inputs.reach), ranges=ranges)

    def _within(self, each: Explaining, signals: Signals) -> bool:
        if not np.all(np.isfinite(signals.y)):
            return False
        q, qd = each.travelled(signals)
        return all(
            lower <= q[:, i].min() and q[:, i].max() <= upper and np.abs(qd[:, i]).max() <= speed
            for i, (lower, upper, speed) in self.ranges.items()
        )


@dataclass(frozen=True, slots=True, eq=False)
class Designed:
    """``u`` (N, nu), None where no input keeps the machine within its limits.

    ``nats`` that the wrong one loses where the first, or the second, is true: both fitted anew to what would be
    recorded, noise and all; ``usual``: what the median input promises. ``nested``: where that one is true, none does.
    """

    u: Array | None
    nats: tuple[float, float]
    nested: tuple[bool, bool]
    usual: float
    wider: float = 0.0  # times the input and all ranges, which would separate where this does not; 0: none would

    @property
    def separation(self) -> float:
        return float(min((n for n, held in zip(self.nats, self.nested, strict=True) if not held), default=0.0))


def design(contest: Contest, seed: int, progress: Progress) -> Designed:
    """The input that tells the pair apart best; the same seed, the same input."""
    points = np.asarray(qmc.Sobol(contest.inputs.size, rng=np.random.default_rng(seed)).random(POOL))
    progress("comparing the explanations under inputs of all kinds")
    table = np.array(side_by_side(contest.nats, list(points)))
    most = table.max(axis=0)
    holds = [_holds(contest.pair[1 - t], contest.pair[t]) for t in (0, 1)]
    nested = [holds[t] or bool(most.max() > 0.0 and most[t] <= NOTHING * most.max()) for t in (0, 1)]
    truths = [truth for truth in (0, 1) if not nested[truth]]
    least = table[:, truths].min(axis=1, initial=np.inf)
    if not truths or least.max() == 0.0:
        return Designed(None, (0.0, 0.0), (nested[0], nested[1]), 0.0)
    progress("searching the input")

    def objective(point: Array) -> float:
        found = contest.nats(point)
        return float(np.log(max(min(found[truth] for truth in truths), 1e-12)))

    point = maximised(objective, points[np.argsort(-least)[:MEMBERS]], EVALUATIONS, seed)
    u = contest.allowed(point)
    assert u is not None  # its objective is more than the least there is
    progress("fitting both explanations to what would be recorded")
    nats = _as_recorded(contest.pair, u, truths, seed)
    found = Designed(u, nats, (nested[0], nested[1]), float(np.median(least)))
    if found.separation >= SEPARATES:
        return found
    best = (point, *points[np.argsort(-least)[:FEW]])
    wider = next((f for f in WIDER if _promises(contest.wider(f), best, truths) >= SEPARATES), 0.0)
    return replace(found, wider=wider)


def _promises(contest: Contest, points: Sequence[Array], truths: Sequence[int]) -> float:
    return max(min(nats[truth] for truth in truths) for nats in side_by_side(contest.nats, points))


def _holds(wide: Explaining, less: Explaining) -> bool:
    """Whether one law is a special case of another at the same place."""
    same = wide.candidate.place == less.candidate.place
    return same and less.candidate.effect in catalogue()[wide.candidate.effect].generalises


def _as_recorded(pair: Pair, u: Array, truths: Sequence[int], seed: int) -> tuple[float, float]:
    rng, found = np.random.default_rng(seed), [0.0, 0.0]
    for truth in truths:
        true, other = pair[truth], pair[1 - truth]
        deviation = np.sqrt(true.fit.bench.noise.r)
        signals = true.shown(u, deviation * rng.standard_normal((len(u), len(deviation))))
        found[truth] = max(0.0, other.refitted(signals) - true.refitted(signals))
    return found[0], found[1]
