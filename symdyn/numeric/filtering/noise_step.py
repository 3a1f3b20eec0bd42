"""One step of Fisher scoring on the noise of a filter: of its sensors, and of the forces that nothing is known of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.bench import FASTEST, TOO_LITTLE, FilterBench, Noise, Pass
from symdyn.numeric.filtering.bounded_step import bounded_step
from symdyn.numeric.filtering.side_by_side import side_by_side

Array = NDArray[np.float64]

PROBE = 0.1  # of the logarithm of a variance, for its difference quotient
LONGEST = 2.0  # step of such a logarithm
NOTHING, BACK = 1e-2, 0.1  # of an innovation's variance: a sensor's that has no slope any more, and what it gets back
FALLING = 0.5  # of such a logarithm: Fisher scoring lowers a variance that is far too large by one, however far it is


def noise_step(bench: FilterBench, p: Array, loss: float) -> tuple[FilterBench, float]:
    """The filter with noise that lowers ``loss``, its -log L at parameters ``p`` (np,), and that; or both as they are.

    Scoring is in logarithms of variances and decays, its slopes difference quotients.
    """
    probed = _probed(bench, p)
    back, after = _brought_back(bench, p, loss, probed[0])
    if after < loss:
        bench, loss, probed = back, after, _probed(back, p)
    here, free, runs = probed
    noise, m = bench.noise, len(bench.noise.r)
    values, lower, upper = _logarithms(noise), *_limits(bench)
    sound = np.array([np.isfinite(there.loss) for there in runs], dtype=bool)  # a covariance may not stay positive
    if not np.isfinite(here.loss) or not sound.any():
        return bench, loss
    free, runs = free[sound], [there for there, good in zip(runs, sound, strict=True) if good]
    gradient = np.array([(there.loss - here.loss) / PROBE for there in runs])
    s = np.array([(np.log(there.variances) - np.log(here.variances)).ravel() / PROBE for there in runs])
    d = np.array([((there.innovations - here.innovations) / np.sqrt(here.variances)).ravel() / PROBE for there in runs])
    fisher = 0.5 * s @ s.T + d @ d.T
    if not np.all(np.isfinite(fisher)):  # of a filter that runs away
        return bench, loss
    fisher += np.diag(1e-3 * np.diag(fisher) + 1e-3)
    gradient -= 0.5 * PROBE * np.diag(fisher)  # half the probe off: the quotient is that of the middle
    change = np.zeros(len(values))
    least, most = np.clip(lower - values, -LONGEST, 0.0), np.clip(upper - values, 0.0, LONGEST)
    change[free] = bounded_step(fisher, -gradient, least[free], most[free])
    factor = 1.0
    while factor > 0.05:
        moved = np.clip(values + factor * change, lower, upper)
        step = (moved - values)[free]
        if -step @ (gradient + 0.5 * fisher @ step) < TOO_LITTLE:
            break
        trial = bench.with_noise(_noise(noise, moved, m))
        found = trial.filtered(p).loss
        if found < loss:
            return _farther(trial, p, change, lower, found)
        factor /= 3.0
    return bench, loss


def _probed(bench: FilterBench, p: Array) -> tuple[Pass, Array, list[Pass]]:
    """The filter as it is; which logarithms may move; and a run with each of those a little larger."""
    values, (lower, upper), m = _logarithms(bench.noise), _limits(bench), len(bench.noise.r)
    free = np.flatnonzero(upper > lower)
    probes = [_noise(bench.noise, values + PROBE * unit, m) for unit in np.eye(len(values))[free]]
    halves = side_by_side(lambda half: bench.beside(p, half), (probes[::2], probes[1::2]))
    return halves[0][0], np.concatenate([free[::2], free[1::2]]), [run for half in halves for run in half[1:]]


def _limits(bench: FilterBench) -> tuple[Array, Array]:
    """Of the logarithms; where they are the same nothing is fitted."""
    noise, step = bench.noise, float(np.nanmedian(bench.signals.steps))
    forces = len(noise.power)
    longest, shortest = 1.0 / (step * len(bench.signals.y)), FASTEST / step
    of_inputs = np.arange(forces) < noise.inputs  # their noise is as quick as it is
    slowest, fastest = (np.where(of_inputs, noise.decay, limit) for limit in (longest, shortest))
    lower = np.concatenate([np.maximum(bench.signals.floor, 1e-300), np.full(forces, 1e-300), slowest])
    upper = np.concatenate([np.full(len(noise.r), np.inf), noise.most, fastest])
    return np.log(lower), np.log(upper)


def _brought_back(bench: FilterBench, p: Array, loss: float, here: Pass) -> tuple[FilterBench, float]:
    """Sensors whose noise an input took over, as long as something was missing, may want some of it back.

    In logarithms a variance of next to nothing has no slope: no later step would find that out.
    """
    with np.errstate(over="ignore"):  # of a filter that runs away
        shown = np.nanmean(here.innovations**2, axis=0)
    for i in np.flatnonzero(bench.noise.r < NOTHING * shown):
        r = bench.noise.r.copy()
        r[i] = BACK * shown[i]
        trial = bench.with_noise(replace(bench.noise, r=r))
        found = trial.filtered(p).loss
        if found < loss:
            bench, loss = trial, found
    return bench, loss


def _farther(bench: FilterBench, p: Array, change: Array, lower: Array, loss: float) -> tuple[FilterBench, float]:
    """Variances that fell far go on falling, twice as far each time, as long as that pays."""
    noise, m = bench.noise, len(bench.noise.r)
    values = _logarithms(noise)
    falling = np.where((change < -FALLING) & (np.arange(len(change)) < m + len(noise.power)), change, 0.0)
    while falling.any():
        values = np.maximum(values + falling, lower)
        trial = bench.with_noise(_noise(noise, values, m))
        found = trial.filtered(p).loss
        if not found < loss:
            break
        bench, loss, falling = trial, found, 2.0 * falling
    return bench, loss


def _logarithms(noise: Noise) -> Array:
    return np.asarray(np.log(np.concatenate([noise.r, noise.power, noise.decay])))


def _noise(noise: Noise, logs: Array, m: int) -> Noise:
    values = np.exp(logs)
    forces = len(noise.power)
    r, power, decay = values[:m].copy(), values[m : m + forces].copy(), values[m + forces :].copy()
    return replace(noise, r=r, power=power, decay=decay)
