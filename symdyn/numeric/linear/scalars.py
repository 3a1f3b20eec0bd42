"""Single numbers of a linear model: what a global sensitivity is about."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from symdyn.base.linear_system import LinearFamily, LinearSystem
from symdyn.numeric.linear.cost import Band
from symdyn.numeric.linear.eigen import poles
from symdyn.numeric.linear.modes import modes
from symdyn.numeric.linear.one_at_a_time import matched
from symdyn.numeric.linear.resolvent import Complex
from symdyn.numeric.linear.response import frequency_response

_POINTS = 60  # of the band in which a magnitude is averaged


@dataclass(frozen=True, slots=True)
class Scalar:
    """A number with a name; NaN where the model does not have it (two poles that have met on the real axis)."""

    name: str
    unit: str
    value: Callable[[LinearSystem], float]


def scalars(
    family: LinearFamily, bands: tuple[Band, ...], input: str | None = None, output: str | None = None
) -> tuple[Scalar, ...]:
    """Frequency and damping ratio of every oscillating mode, and the mean magnitude of the response in each band."""
    nominal = family.nominal
    reference = poles(nominal).values
    # asked for by every number of one model in turn
    now = lru_cache(maxsize=1)(lambda system: matched(reference, poles(system).values))
    found = []
    for k, mode in enumerate(modes(nominal)):
        if mode.pole.imag > 0:
            found.append(Scalar(f"frequency: {mode.name}", "Hz", _of_pole(now, k, _frequency)))
            found.append(Scalar(f"damping: {mode.name}", "1", _of_pole(now, k, _damping)))
    for band in bands:
        label = f"magnitude: {band.low:.4g} to {band.high:.4g} Hz"
        found.append(Scalar(label, "dB", _mean_magnitude(band, input, output)))
    return tuple(found)


def _frequency(pole: complex) -> float:
    return abs(pole) / (2 * np.pi)


def _damping(pole: complex) -> float:
    return -pole.real / abs(pole)


def _of_pole(
    now: Callable[[LinearSystem], Complex], k: int, number: Callable[[complex], float]
) -> Callable[[LinearSystem], float]:
    def value(system: LinearSystem) -> float:
        pole = complex(now(system)[k])
        return number(pole) if pole.imag > 0 else np.nan

    return value


def _mean_magnitude(band: Band, input: str | None, output: str | None) -> Callable[[LinearSystem], float]:
    hertz = band.hertz(_POINTS)
    return lambda system: float(np.mean(frequency_response(system, hertz, input, output).decibel))
