"""Latent-force evidence: at which equation or coupling an unknown force would explain the recording best."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from symdyn.numeric.filtering.bench import FilterBench, Noise
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.graduated import graduated
from symdyn.numeric.filtering.likelihood import MLFit, fit
from symdyn.numeric.filtering.model import Model, natural_force, with_latent, without_latent
from symdyn.numeric.filtering.places import Latent
from symdyn.numeric.filtering.side_by_side import side_by_side
from symdyn.numeric.filtering.signals import stretch
from symdyn.numeric.regression import long_run_covariance

Array = NDArray[np.float64]

POWERS = np.logspace(-5, 1, 7)  # of a latent force, relative to what moves the machine: where its fit starts
ROUGH, ROUNDS = 2.0, 15  # nats and rounds of a fit that only locates
TOGETHER = 5.0  # nats: what is closer than this is not told apart (odds of 150 to 1 would tell it)
TWO = 2  # forces that are tried next to each other, from where the likeliest so far led
FEWEST, SWINGS = 2000, 4.0  # samples of a stretch that is looked at first, and times its hidden parts must settle
EITHER = (Between.STRAIGHT, Between.HELD)  # to begin with
FEW = 4  # rounds that tell whether an input is held, or that a force is none of the likeliest
NEAR = 200.0  # nats behind the best: forces that are fitted further
APART = float(stats.norm.isf(0.005))  # standard errors of a difference of likelihoods, two-sided at 1 %


@dataclass(frozen=True, eq=False)
class Place:
    """An unknown force at one place, with everything else fitted again. ``gain`` in nats over none at all."""

    latent: Latent
    fit: MLFit
    gain: float

    @cached_property
    def samples(self) -> Array:
        """(N,) log-likelihood of each training sample."""
        done = self.fit.bench.filtered(self.fit.p)
        return np.asarray(-0.5 * np.sum(done.white**2 + np.log(done.variances), axis=1))


def alone(model: Model, progress: Callable[[str], None]) -> MLFit:
    """The model without any unknown force, its inputs held between samples or going straight: what is likelier."""
    progress("the model as given")
    part = brief(model)
    noise = without_latent(model, part.training)
    bench, near = graduated(part, part.bench(part.training, noise, Between.HELD), model.values, model.beliefs)
    ways = side_by_side(lambda way: _closer(bench.with_inputs(way), near, model), EITHER)
    return _whole(model, min(ways, key=lambda each: each.loss))


def locate(model: Model, none: MLFit, progress: Callable[[str], None]) -> tuple[MLFit, tuple[Place, ...]]:
    """The model without any unknown force, fitted (``none``: a first fit), and with one at each place, best first.

    All are fitted to a stretch of the recording first, and the likeliest then to all of it.
    """
    part, first = brief(model), model.latents[0]
    noise = without_latent(model, part.training)
    progress(f"an unknown force at {first.place}")
    ways = side_by_side(lambda way: _fitted(part, first, model.values, noise, way, FEW), EITHER)
    likeliest = min((_whole(part, none, 0), *ways), key=lambda each: each.loss)
    between = likeliest.bench.between
    best = _fitted(part, first, likeliest.p, likeliest.bench.noise, between, ROUNDS)
    fits = [best]
    for i in range(1, len(model.latents), TWO):
        two = model.latents[i : i + TWO]
        progress(f"an unknown force at {' and at '.join(latent.place for latent in two)}")
        begin = partial(_fitted, part, p=best.p, noise=best.bench.noise, between=between, most=FEW)
        fits += side_by_side(begin, two)
        best = min(fits, key=lambda each: each.loss)
    least = best.loss + NEAR * len(part.training.y) / len(model.training.y)
    progress("the likeliest of these places, closer; and no unknown force")
    whole = side_by_side(lambda rough: _whole(model, rough, ROUNDS if rough.loss < least else 0), fits)
    best = min(whole, key=lambda each: each.loss)
    again = _closer(best.bench.with_noise(best.bench.noise.quiet), best.p, model)
    none = min(none, again, key=lambda each: each.loss)
    places = tuple(Place(latent, f, none.loss - f.loss) for latent, f in zip(model.latents, whole, strict=True))
    return none, tuple(sorted(places, key=lambda place: -place.gain))


def brief(model: Model) -> Model:
    """The same on a stretch of what it is fitted to, long enough for its slowest swings."""
    signals = model.training
    bench = model.bench(signals, without_latent(model, signals), Between.STRAIGHT)
    count = max(FEWEST, math.ceil(SWINGS * bench.settling / float(np.nanmedian(signals.steps))))
    return replace(model, training=stretch(signals, count))


def _whole(model: Model, rough: MLFit, most: int = ROUNDS) -> MLFit:
    """The fit, going on with all of what ``model`` is fitted to for some rounds; none: as it is."""
    bench = model.bench(model.training, rough.bench.noise, rough.bench.between)
    return fit(bench, rough.p, model.beliefs, settled=ROUGH, most=most)


def together(place: Place, places: Sequence[Place]) -> tuple[str, ...]:
    """Places that the recording cannot tell from this one: the likelihood of neither is certainly higher."""
    return tuple(
        p.latent.place for p in places if p is place or (p.gain > 0 and not certainly_apart(place.samples, p.samples))
    )


def certainly_apart(first: Array, second: Array) -> bool:
    """Whether two models differ in likelihood beyond chance (Vuong 1989); correlated samples are allowed for."""
    difference = first - second
    mean = float(np.mean(difference))
    if abs(mean) * len(difference) < TOGETHER:
        return False
    spread = float(np.sqrt(max(long_run_covariance(difference[:, None])[0, 0], 0.0) / len(difference)))
    return abs(mean) > APART * spread


def _closer(bench: FilterBench, p: Array, model: Model) -> MLFit:
    return fit(bench, p, model.beliefs, settled=ROUGH, most=ROUNDS)


def _fitted(model: Model, latent: Latent, p: Array, noise: Noise, between: Between, most: int = ROUNDS) -> MLFit:
    bench = model.bench(model.training, noise, between)
    powers = natural_force(model, model.training, latent.direction) ** 2 * POWERS
    trials = [bench.with_noise(with_latent(noise, latent, float(power))) for power in powers]
    losses = side_by_side(lambda trial: trial.filtered(p).loss, trials)
    return fit(trials[int(np.argmin(losses))], p, model.beliefs, settled=ROUGH, most=most)
