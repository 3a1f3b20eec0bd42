"""Maximum likelihood: parameters and noise of a model, from the innovations of its filter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.bench import FilterBench, Noise, Pass
from symdyn.numeric.filtering.side_by_side import side_by_side
from symdyn.numeric.regression import long_run_covariance

Array = NDArray[np.float64]

ITERATIONS = 30
SETTLED = 0.5  # nats: what half of a sample's noise says
PROBE = 0.1  # of the logarithm of a variance, for its difference quotient
LONGEST = 2.0  # step of such a logarithm
FALLING = 0.5  # of such a logarithm: Fisher scoring lowers a variance that is far too large by one, however far it is
FIRST_DAMPING, LEAST_DAMPED, MOST_DAMPED = 1e-3, 1e-9, 1e9  # of the curvature
DIFFERENCE = 0.1  # of a standard error, for difference quotients by parameters
MODEST = 1e-6  # curvature that is added where there is none at all
FASTEST = 0.5  # decay of a latent force, per sample: faster is white noise


@dataclass(frozen=True, slots=True)
class Belief:
    """What is known of a parameter beforehand: bounds, and a normal prior (``spread`` inf: none).

    Of a ``positive`` one all of it, but for the bounds, is meant of its logarithm.
    """

    lower: float = -np.inf
    upper: float = np.inf
    centre: float = 0.0
    spread: float = np.inf
    positive: bool = False

    def coordinate(self, value: float) -> float:
        return float(np.log(value)) if self.positive else value

    def value(self, coordinate: float) -> float:
        return float(np.exp(coordinate)) if self.positive else float(np.clip(coordinate, self.lower, self.upper))


Beliefs = Mapping[str, Belief]


@dataclass(frozen=True, eq=False)
class MLFit:
    """``p`` (np,), fitted where ``beliefs`` names it; ``bench`` holds the noise fitted along; ``loss`` is -log L."""

    beliefs: Beliefs
    p: Array
    bench: FilterBench
    loss: float

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.beliefs)

    @cached_property
    def covariance(self) -> Array:
        """(k, k) of the named parameters."""
        return _covariance(self.bench, self.p, self.beliefs)


def untold(start: float) -> Belief:
    """Of a positive parameter that no data sheet told, about where its fit starts: a factor of ten either way."""
    return Belief(positive=True, centre=float(np.log(start)), spread=float(np.log(10.0)))


def fit(bench: FilterBench, p: Array, beliefs: Beliefs, *, settled: float = SETTLED, most: int = ITERATIONS) -> MLFit:
    """Fisher scoring on -log L, by turns of the parameters that ``beliefs`` names and of the noise.

    One of them that gains less than ``settled`` nats waits until the other does, too. It ends when both together gain
    less, or after ``most`` rounds.
    """
    p, names = p.copy(), bool(beliefs)
    bench = _scaled(bench, p)
    loss, damping = bench.filtered(p).loss + _penalty(bench, p, beliefs), FIRST_DAMPING
    of_parameters, of_noise = names, True  # whose turn it is
    off = None
    for _ in range(most):
        before = loss
        if of_parameters:
            p, loss, damping, off = _parameter_step(bench, p, beliefs, (loss, damping), off)
        between = loss
        if of_noise:
            prior = _penalty(bench, p, beliefs)
            bench, loss = _noise_step(bench, p, loss - prior)
            loss += prior
        together = of_noise and of_parameters == names
        if together and before - loss < settled:
            break
        if together and names:
            of_parameters, of_noise = before - between >= settled, between - loss >= settled
        elif before - loss < settled:
            of_parameters, of_noise = names, True
    return MLFit(beliefs, p, bench, loss)


def _scaled(bench: FilterBench, p: Array) -> FilterBench:
    """Noise of every channel brought to what its innovations show, where that helps: most of the way from a guess."""
    done = bench.filtered(p)
    for _ in range(2):
        ratio = np.mean(done.white**2, axis=0)
        ratio = np.where(np.isfinite(ratio), np.clip(ratio, 1e-4, 1e4), 1.0)
        trial = bench.with_noise(replace(bench.noise, r=np.maximum(bench.noise.r * ratio, bench.signals.floor)))
        after = trial.filtered(p)
        if not after.loss < done.loss:
            break
        bench, done = trial, after
    return bench


def _penalty(bench: FilterBench, p: Array, beliefs: Beliefs) -> float:
    return sum(0.5 * ((b.coordinate(p[bench.index[n]]) - b.centre) / b.spread) ** 2 for n, b in beliefs.items())


def _parameter_step(
    bench: FilterBench, p: Array, beliefs: Beliefs, at: tuple[float, float], off: tuple[Array, Array] | None
) -> tuple[Array, float, float, tuple[Array, Array] | None]:
    """One step of Levenberg and Marquardt within bounds: (parameters, loss, damping for the next one, ``off``).

    Where friction jumps within a step of the filter, the innovations' slopes may point elsewhere. Where they promise a
    gain and lead to none, differences take their place; how far ``off`` the slopes were is remembered for later steps.
    """
    loss, damping = at
    where = [bench.index[name] for name in beliefs]
    known = tuple(beliefs.values())
    done = bench.filtered(p, tuple(beliefs))
    columns = _columns(done, p, where, known)
    if not np.all(np.isfinite(columns)):  # on the way to infinity: nothing is known of a better direction
        return p, loss, damping, off
    slope = columns.T @ done.white.ravel()
    corrected = (columns, slope) if off is None else (columns + off[0], slope + off[1])
    found, promised = _lower(bench, p, beliefs, at, *corrected)
    if promised > SETTLED and (found is None or loss - found[1] < SETTLED):
        better = _by_differences(bench, p, beliefs, done, columns)
        off = better[0] - columns, better[1] - slope
        found = _lower(bench, p, beliefs, (loss, FIRST_DAMPING), *better)[0] or found
    return *(found or (p, loss, 1.0)), off


def _lower(
    bench: FilterBench, p: Array, beliefs: Beliefs, at: tuple[float, float], columns: Array, slope: Array
) -> tuple[tuple[Array, float, float] | None, float]:
    """A step that lowers the loss, if any does: (parameters, loss, damping); and the gain that the slopes promise."""
    loss, damping = at
    where = [bench.index[name] for name in beliefs]
    known = tuple(beliefs.values())
    here = np.array([b.coordinate(p[i]) for i, b in zip(where, known, strict=True)])
    positive = np.array([b.positive for b in known], dtype=bool)
    length = np.linalg.norm(columns, axis=0)
    scale = np.where(positive, 1.0, 1.0 / np.where(length > 0, length, 1.0))
    precision = np.array([b.spread**-2 for b in known])
    wish = precision * (np.array([b.centre for b in known]) - here)
    normal = (columns.T @ columns + np.diag(precision)) * np.outer(scale, scale)
    slope = (slope + wish) * scale
    lower = np.array([-np.inf if b.positive else b.lower for b in known])
    upper = np.array([np.inf if b.positive else b.upper for b in known])
    growth, promised = 10.0, 0.0
    while damping < MOST_DAMPED:
        damped = normal + damping * np.diag(np.diag(normal) + MODEST)
        step = _within(damped, slope, (lower - here) / scale, (upper - here) / scale)
        promised = max(promised, float(slope @ step - 0.5 * step @ normal @ step))
        trial = p.copy()
        if np.max(np.abs(step[positive]), initial=0.0) < LONGEST:
            trial[where] = [b.value(x) for b, x in zip(known, here + scale * step, strict=True)]
            found = bench.filtered(trial).loss + _penalty(bench, trial, beliefs)
            if found < loss:
                return (trial, found, max(damping / 10.0, LEAST_DAMPED)), promised
        damping *= growth
        growth *= 2.0
    return None, promised


def _by_differences(bench: FilterBench, p: Array, beliefs: Beliefs, done: Pass, columns: Array) -> tuple[Array, Array]:
    """Columns as ``_columns`` has them, and the slope of the likelihood: a run of the filter for each parameter."""
    length = np.linalg.norm(columns, axis=0)
    moved = DIFFERENCE * np.minimum(1.0, 1.0 / np.where(length > 0, length, 1.0))
    trials = []
    for j, (name, belief) in enumerate(beliefs.items()):
        i = bench.index[name]
        trial = p.copy()
        trial[i] = belief.value(belief.coordinate(p[i]) + moved[j])
        if trial[i] == p[i]:  # at its bound
            moved[j] = -moved[j]
            trial[i] = belief.value(belief.coordinate(p[i]) + moved[j])
        trials.append(trial)
    runs = side_by_side(bench.filtered, trials)
    sound = np.array([np.isfinite(there.loss) for there in runs])
    spread = np.sqrt(done.variances)
    found = np.stack([((done.innovations - there.innovations) / spread).ravel() for there in runs], axis=1) / moved
    found = np.where(sound, found, columns)
    gain = np.array([done.loss - there.loss if good else 0.0 for there, good in zip(runs, sound, strict=True)]) / moved
    return found, gain + 0.5 * moved * np.sum(found**2, axis=0)  # the quotient is that of the middle


def _columns(done: Pass, p: Array, where: Sequence[int], known: Sequence[Belief]) -> Array:
    """(N m, k) what each coordinate takes off the whitened innovations."""
    factor = np.array([p[i] if b.positive else 1.0 for i, b in zip(where, known, strict=True)])
    columns: Array = -done.slopes / np.sqrt(done.variances)[:, :, None] * factor
    return columns.reshape(-1, len(where))


def _within(normal: Array, slope: Array, lower: Array, upper: Array) -> Array:
    """The solution of the normal equations, what runs into a bound held there (one way in, none out)."""
    step, free = np.zeros(len(slope)), np.ones(len(slope), dtype=bool)
    for _ in range(len(slope)):
        right = slope[free] - normal[np.ix_(free, ~free)] @ step[~free]
        step[free] = np.linalg.lstsq(normal[np.ix_(free, free)], right, rcond=1e-14)[0]
        out = free & ((step < lower) | (step > upper))
        if not out.any():
            break
        step = np.where(out, np.clip(step, lower, upper), step)
        free &= ~out
    return step


def _noise_step(bench: FilterBench, p: Array, loss: float) -> tuple[FilterBench, float]:
    noise = bench.noise
    values = np.log(np.concatenate([noise.r, noise.power, noise.decay]))
    step = float(np.nanmedian(bench.signals.steps))
    forces = len(noise.power)
    longest, shortest = 1.0 / (step * len(bench.signals.y)), FASTEST / step
    slowest = np.where(np.arange(forces) < noise.inputs, shortest, longest)
    lower = np.concatenate([np.maximum(bench.signals.floor, 1e-300), np.full(forces, 1e-300), slowest])
    upper = np.concatenate([np.full(len(noise.r) + forces, np.inf), np.full(forces, shortest)])
    lower, upper = np.log(lower), np.log(upper)
    m = len(noise.r)
    free = np.flatnonzero(upper > lower)
    probes = [_noise(noise, values + PROBE * unit, m) for unit in np.eye(len(values))[free]]
    halves = side_by_side(lambda half: bench.beside(p, half), (probes[::2], probes[1::2]))
    here, runs = halves[0][0], [run for half in halves for run in half[1:]]
    free = np.concatenate([free[::2], free[1::2]])
    sound = np.array([np.isfinite(there.loss) for there in runs], dtype=bool)  # a covariance may not stay positive
    if not np.isfinite(here.loss) or not sound.any():
        return bench, loss
    free, runs = free[sound], [there for there, good in zip(runs, sound, strict=True) if good]
    gradient = np.array([(there.loss - here.loss) / PROBE for there in runs])
    s = np.array([(np.log(there.variances) - np.log(here.variances)).ravel() / PROBE for there in runs])
    d = np.array([((there.innovations - here.innovations) / np.sqrt(here.variances)).ravel() / PROBE for there in runs])
    fisher = 0.5 * s @ s.T + d @ d.T
    fisher += np.diag(1e-3 * np.diag(fisher) + 1e-3)
    # half the probe off: the quotient is that of the middle
    change = np.zeros(len(values))
    change[free] = np.clip(-np.linalg.solve(fisher, gradient - 0.5 * PROBE * np.diag(fisher)), -LONGEST, LONGEST)
    factor = 1.0
    while factor > 0.05:
        moved = np.clip(values + factor * change, lower, upper)
        trial = bench.with_noise(_noise(noise, moved, m))
        found = trial.filtered(p).loss
        if found < loss:
            return _farther(trial, p, change, lower, found)
        factor /= 3.0
    return bench, loss


def _farther(bench: FilterBench, p: Array, change: Array, lower: Array, loss: float) -> tuple[FilterBench, float]:
    """Variances that fell far go on falling, twice as far each time, as long as that pays."""
    noise, m = bench.noise, len(bench.noise.r)
    values = np.log(np.concatenate([noise.r, noise.power, noise.decay]))
    falling = np.where((change < -FALLING) & (np.arange(len(change)) < m + len(noise.power)), change, 0.0)
    while falling.any():
        values = np.maximum(values + falling, lower)
        trial = bench.with_noise(_noise(noise, values, m))
        found = trial.filtered(p).loss
        if not found < loss:
            break
        bench, loss, falling = trial, found, 2.0 * falling
    return bench, loss


def _noise(noise: Noise, logs: Array, m: int) -> Noise:
    values = np.exp(logs)
    forces = len(noise.power)
    r, power, decay = values[:m].copy(), values[m : m + forces].copy(), values[m + forces :].copy()
    return replace(noise, r=r, power=power, decay=decay)


def _covariance(bench: FilterBench, p: Array, beliefs: Beliefs) -> Array:
    """The sandwich: curvature of the likelihood on both sides of what its slope really scatters by.

    Innovations of an approximate model are not white; Newey and West's sum (1987) allows for that.
    """
    if not beliefs:
        return np.zeros((0, 0))
    known, where = tuple(beliefs.values()), [bench.index[name] for name in beliefs]
    done = bench.filtered(p, tuple(beliefs))
    flat = _columns(done, p, where, known)
    if not np.all(np.isfinite(flat)):
        return np.full((len(known), len(known)), np.inf)
    precision = flat.T @ flat + np.diag([b.spread**-2 for b in known])
    scale = np.sqrt(np.diag(precision))
    scale = np.where(scale > 0, scale, 1.0)
    inverse = np.linalg.pinv(precision / np.outer(scale, scale), rcond=1e-15, hermitian=True) / np.outer(scale, scale)
    samples = flat.reshape(*done.innovations.shape, len(known))
    slopes = np.einsum("kmq,km->kq", samples, done.white) / scale
    middle = long_run_covariance(slopes) * len(slopes) * np.outer(scale, scale)
    middle += np.diag([b.spread**-2 for b in known])
    factor = np.array([p[i] if b.positive else 1.0 for i, b in zip(where, known, strict=True)])
    robust = inverse @ middle @ inverse
    larger = np.sqrt(np.maximum(1.0, np.diag(inverse) / np.maximum(np.diag(robust), 1e-300)))
    return np.asarray(robust * np.outer(larger * factor, larger * factor))  # never below that of white innovations
