"""The noise of the effort sensors, from frequencies where nothing else is, carried down to the analysis band."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import signal, special

from symdyn.numeric.band import SAMPLES_PER_PERIOD
from symdyn.numeric.observation import FILTER_ORDER, Observation
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

CLEAR = 1.2  # of the frequency up to which positions were differentiated: above it the residual is the sensor's alone
FEWEST_BINS = 8
# Area of a Butterworth filter's power gain, run forwards and backwards, over that of an ideal one of the same edge.
_x = 1.0 / (2 * FILTER_ORDER)
AREA = float(_x * special.beta(_x, 2.0 - _x))


def noise_density(bench: Workbench, p: Array) -> Array:
    """(n,) amplitude density of each effort's noise per root hertz.

    The median level of the residual's spectrum above the band in which positions were differentiated;
    where the recording does not reach that far, of the highest quarter of its frequencies. A sensor
    that filters shows less there than it has in the band: then this is a lower bound.
    """
    _, power, freedom = _of_sensors(bench, p)
    return np.asarray(np.sqrt(_level(power, freedom)))


def loudest_density(bench: Workbench, p: Array) -> Array:
    """(n,) the same of the loudest octave: what may at most be the sensor's, if its noise grows towards the band."""
    frequency, power, freedom = _of_sensors(bench, p)
    octave = np.floor(np.log2(frequency / frequency[0]))
    parts = [power[octave == k] for k in range(int(octave[-1]) + 1)]
    levels = [_level(part, freedom) for part in parts if len(part) >= FEWEST_BINS]
    return np.asarray(np.sqrt(np.max([_level(power, freedom), *levels], axis=0)))


def _of_sensors(bench: Workbench, p: Array) -> tuple[Array, Array, float]:
    """Frequencies (m,) at which a residual is the sensors' alone, its power density (m, n), and its freedom."""
    o = bench.observation
    frequency, power, freedom = power_density(bench.raw_residual(p) * o.shown, o)
    clear = frequency > CLEAR * o.cutoff
    if np.count_nonzero(clear) < FEWEST_BINS:
        clear = frequency > 0.75 * frequency[-1]
    return frequency[clear], power[clear], freedom


def power_density(values: Array, observation: Observation) -> tuple[Array, Array, float]:
    """Of values (N, n) over the longest stretch: frequencies (m,) in Hz, density per hertz (m, n), and its freedom."""
    longest = max(observation.segments, key=lambda part: part.stop - part.start)
    count = longest.stop - longest.start
    length = min(count, 1024)
    at, power = signal.welch(values[longest], observation.rate, nperseg=length, axis=0, detrend="constant")
    return at, power, 2.0 * count / length


def _level(power: Array, freedom: float) -> Array:
    """(n,) The median of chi-squared numbers lies below their mean."""
    return np.asarray(np.median(power, axis=0) * freedom / special.chdtri(freedom, 0.5))


def in_band(density: Array, bench: Workbench) -> Array:
    """(n,) root mean square of white noise of that density in the analysis band."""
    rate = bench.observation.rate
    edge = bench.band.cutoff * AREA if bench.band else rate / 2.0
    return np.asarray(density * np.sqrt(min(edge, rate / 2.0)))


def independent_samples(bench: Workbench) -> float:
    """How many independent numbers a joint's residual holds in the band: two per hertz and second."""
    return len(bench.effort) * min(1.0, 2.0 / max(bench.samples_per_period, SAMPLES_PER_PERIOD / 2.0))
