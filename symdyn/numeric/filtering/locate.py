"""Latent-force evidence: at which equation or coupling an unknown force would explain the recording best."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from symdyn.numeric.filtering.bench import FilterBench, Noise
from symdyn.numeric.filtering.graduated import graduated
from symdyn.numeric.filtering.likelihood import MLFit, fit
from symdyn.numeric.filtering.model import Model, natural_force, with_latent, without_latent
from symdyn.numeric.filtering.places import Latent
from symdyn.numeric.regression import long_run_covariance

Array = NDArray[np.float64]

POWERS = np.logspace(-5, 1, 7)  # of a latent force, relative to what moves the machine: where its fit starts
ROUGH, ROUNDS = 2.0, 15  # nats and rounds of a fit that only locates
TOGETHER = 5.0  # nats: what is closer than this is not told apart (odds of 150 to 1 would tell it)
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


def locate(model: Model, progress: Callable[[str], None]) -> tuple[MLFit, tuple[Place, ...]]:
    """The model without any unknown force, fitted, and with one at each place, best first."""
    fits: list[tuple[Latent, MLFit]] = []
    p, held, noise = model.values, False, without_latent(model, model.training)
    for latent in model.latents:
        progress(f"an unknown force at {latent.place}")
        if not fits:  # whether inputs are held between samples, or go straight: what the innovations say
            ways = [_fitted(model, latent, p, noise, way, FEW) for way in (False, True)]
            likeliest = min((*ways, *_without(model, noise)), key=lambda each: each.loss)
            p, noise, held = likeliest.p, likeliest.bench.noise, likeliest.bench.held
        fits.append((latent, _fitted(model, latent, p, noise, held, ROUNDS if not fits else FEW)))
        best = min(fits, key=lambda item: item[1].loss)[1]
        p, noise = best.p, best.bench.noise
    for i, (latent, rough) in enumerate(fits):
        if rough.loss - best.loss < NEAR:
            progress(f"an unknown force at {latent.place}, closer")
            fits[i] = latent, _closer(rough.bench, rough, model)
    progress("no unknown force")
    best = min(fits, key=lambda item: item[1].loss)[1]
    none = _closer(best.bench.with_noise(best.bench.noise.quiet), best, model)
    places = tuple(Place(latent, done, none.loss - done.loss) for latent, done in fits)
    return none, tuple(sorted(places, key=lambda place: -place.gain))


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


def _without(model: Model, noise: Noise) -> list[MLFit]:
    """Fits without an unknown force, of inputs that go straight or are held, from where many forces led to."""
    bench, near = graduated(model, model.bench(model.training, noise, True), model.values, model.beliefs)
    return [fit(bench.with_inputs(held), near, model.beliefs, settled=ROUGH, most=ROUNDS) for held in (False, True)]


def _closer(bench: FilterBench, start: MLFit, model: Model) -> MLFit:
    return fit(bench, start.p, model.beliefs, settled=ROUGH, most=ROUNDS)


def _fitted(model: Model, latent: Latent, p: Array, noise: Noise, held: bool, most: int = ROUNDS) -> MLFit:
    bench = model.bench(model.training, noise, held)
    powers = natural_force(model, model.training, latent.direction) ** 2 * POWERS
    trials = [bench.with_noise(with_latent(noise, latent, float(power))) for power in powers]
    losses = [trial.filtered(p).loss for trial in trials]
    return fit(trials[int(np.argmin(losses))], p, model.beliefs, settled=ROUGH, most=most)
