"""Maximum likelihood: parameters and noise of a model, from the innovations of its filter."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.beliefs import Beliefs, penalty, per_coordinate, precision
from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.noise_step import noise_step
from symdyn.numeric.filtering.parameter_step import At, columns, parameter_step
from symdyn.numeric.filtering.scale import as_believed
from symdyn.numeric.filtering.windows import white_noise
from symdyn.numeric.regression import long_run_covariance

Array = NDArray[np.float64]

ITERATIONS = 30
SETTLED = 0.5  # nats: what half of a sample's noise says
CLEAR = 4.0  # times the largest variance that white noise of a sensor can have: more is no noise of its own
NOTHING = 1e-6  # of the variance that noise of an input begins with


@dataclass(frozen=True, eq=False)
class MLFit:
    """``p`` (np,), fitted where ``beliefs`` names it; ``bench`` holds the noise fitted along; ``loss`` is -log L.

    Where that was asked: ``discretisation`` (k,), how far off the steps of the filter may have put each value, and
    ``finer``, the filter with shorter ones (where two parameters are nearly one, slopes that are a per cent off tell
    them apart); and ``reach`` (k,), how many times as far as its curvature says the likelihood does not tell.
    """

    beliefs: Beliefs
    p: Array
    bench: FilterBench
    loss: float
    discretisation: Array | None = None
    finer: FilterBench | None = None
    reach: Array | None = None

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.beliefs)

    @cached_property
    def covariance(self) -> Array:
        """(k, k) of the named parameters."""
        random = _covariance(self.finer or self.bench, self.p, self.beliefs)
        if self.discretisation is not None:
            random = random + np.outer(self.discretisation, self.discretisation)
        return random if self.reach is None else random * np.outer(self.reach, self.reach)


def fit(
    bench: FilterBench,
    p: Array,
    beliefs: Beliefs,
    *,
    settled: float = SETTLED,
    most: int = ITERATIONS,
) -> MLFit:
    """Fisher scoring on -log L, by turns of the parameters that ``beliefs`` names and of the noise.

    One of them that gains less than ``settled`` nats waits until the other does, too. It ends when both together gain
    less, or after ``most`` rounds, with all forces as large as is believed most, where nothing else tells.
    """
    bench, loss = _begun(bench, p)
    bench, at = _settled(bench, At(p.copy(), loss + penalty(p, bench.index, beliefs)), beliefs, settled, most)
    clear = _clear(bench, at, beliefs)
    if clear is not None:
        bench, at = _settled(*clear, beliefs, settled, most)
    bench, p, loss = as_believed(bench, at.p, at.loss, beliefs)
    return MLFit(beliefs, p, bench, loss)


def _settled(bench: FilterBench, at: At, beliefs: Beliefs, settled: float, most: int) -> tuple[FilterBench, At]:
    names = bool(beliefs)
    of_parameters, of_noise = names, True  # whose turn it is
    for _ in range(most):
        before = at.loss
        if of_parameters:
            at = parameter_step(bench, at, beliefs)
        between = at.loss
        if of_noise:
            prior = penalty(at.p, bench.index, beliefs)
            bench, loss = noise_step(bench, at.p, at.loss - prior)
            at = replace(at, loss=loss + prior)
        together = of_noise and of_parameters == names
        if together and before - at.loss < settled:
            break
        if together and names:
            of_parameters, of_noise = before - between >= settled, between - at.loss >= settled
        elif before - at.loss < settled:
            of_parameters, of_noise = names, True
    return bench, at


def _clear(bench: FilterBench, at: At, beliefs: Beliefs) -> tuple[FilterBench, At] | None:
    """Where the fit goes on with sensors as clear as they show, and inputs as noisy; None where that is less likely.

    What the noise of an input does to a machine that swings may have been taken for the noise of a sensor while
    something was missing, and small steps do not lead from one to the other.
    """
    noise, white = bench.noise, white_noise(bench.signals)
    if np.all(noise.r <= CLEAR * white):
        return None
    power = noise.power.copy()
    power[: noise.inputs] = np.maximum(power[: noise.inputs], noise.shown)
    clear, loss = _scaled(bench.with_noise(replace(noise, r=np.minimum(noise.r, white), power=power)), at.p)
    loss += penalty(at.p, bench.index, beliefs)
    return (clear, At(at.p, loss)) if loss < at.loss else None


def _begun(bench: FilterBench, p: Array) -> tuple[FilterBench, float]:
    """Noise that a fit may begin with, and its -log L: as it is, or with its first where inputs have none left.

    The likelier of the two: an unknown force may have done its work, and in logarithms a variance of next to nothing
    has no slope, so that no step would find out that some is there.
    """
    noise, scaled = bench.noise, _scaled(bench, p)
    gone = np.append(
        noise.power[: noise.inputs] < NOTHING * noise.first, np.zeros(len(noise.power) - noise.inputs, bool)
    )
    if not gone.any():
        return scaled
    power = np.where(gone, np.append(noise.first, noise.power[noise.inputs :]), noise.power)
    return min(scaled, _scaled(bench.with_noise(replace(noise, power=power)), p), key=lambda each: each[1])


def _scaled(bench: FilterBench, p: Array) -> tuple[FilterBench, float]:
    """Noise of every channel brought to what its innovations show, where that helps; and -log L with it.

    That is most of the way from a guess.
    """
    done = bench.filtered(p)
    for _ in range(2):
        ratio = np.mean(done.white**2, axis=0)
        ratio = np.where(np.isfinite(ratio), np.clip(ratio, 1e-4, 1e4), 1.0)
        trial = bench.with_noise(replace(bench.noise, r=np.maximum(bench.noise.r * ratio, bench.signals.floor)))
        after = trial.filtered(p)
        if not after.loss < done.loss:
            break
        bench, done = trial, after
    return bench, done.loss


def _covariance(bench: FilterBench, p: Array, beliefs: Beliefs) -> Array:
    """The sandwich: curvature of the likelihood on both sides of what its slope really scatters by.

    Innovations of an approximate model are not white; Newey and West's sum (1987) allows for that.
    """
    if not beliefs:
        return np.zeros((0, 0))
    known, where = tuple(beliefs.values()), [bench.index[name] for name in beliefs]
    done = bench.filtered(p, tuple(beliefs))
    flat = columns(done, p, where, known)
    if not np.all(np.isfinite(flat)):
        return np.full((len(known), len(known)), np.inf)
    believed = precision(beliefs)
    curvature = flat.T @ flat + believed
    scale = np.sqrt(np.diag(curvature))
    scale = np.where(scale > 0, scale, 1.0)
    inverse = np.linalg.pinv(curvature / np.outer(scale, scale), rcond=1e-15, hermitian=True) / np.outer(scale, scale)
    samples = flat.reshape(*done.innovations.shape, len(known))
    slopes = np.einsum("kmq,km->kq", samples, done.white) / scale
    middle = long_run_covariance(slopes) * len(slopes) * np.outer(scale, scale)
    middle += believed
    factor = per_coordinate(p[where], known)
    robust = inverse @ middle @ inverse
    larger = np.sqrt(np.maximum(1.0, np.diag(inverse) / np.maximum(np.diag(robust), 1e-300)))
    return np.asarray(robust * np.outer(larger * factor, larger * factor))  # never below that of white innovations
