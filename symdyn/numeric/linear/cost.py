"""What a simpler model costs: the error of its frequency response over a band, and for a signal in it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from symdyn.base.linear_system import Array
from symdyn.numeric.linear.resolvent import Complex
from symdyn.numeric.linear.signals import grid

POINTS = 600


class Signal(StrEnum):
    """What drives the machine: its amplitude density over the band."""

    STEP = "step"  # 1 / f
    WHITE = "white"  # even


@dataclass(frozen=True, slots=True)
class Band:
    """Where, and for what, a simpler model must be good."""

    low: float  # Hz
    high: float
    signal: Signal = Signal.STEP

    def hertz(self, points: int = POINTS) -> Array:
        """Evenly spaced in their logarithm; UsageError (SD302) for a band that is none."""
        return grid(self.low, self.high, points)

    def weight(self, hertz: Array) -> Array:
        """Power of the signal per step of that grid."""
        return 1.0 / hertz if self.signal is Signal.STEP else hertz


@dataclass(frozen=True, slots=True)
class Cost:
    """``worst`` is the largest |change of G| / |G| in the band, at ``hertz``; ``decibel`` the largest change of |G|.

    ``rms`` is the r.m.s. error of the output over its r.m.s. value, for the signal. All are infinite where the
    simpler model has no finite response.
    """

    worst: float
    hertz: float
    decibel: float
    rms: float


def cost(band: Band, hertz: Array, exact: Complex, simpler: Complex) -> Cost:
    """Of ``simpler`` (N,) against ``exact`` (N,) on the band's own grid ``hertz``."""
    if not np.isfinite(simpler).all():
        return Cost(np.inf, float(hertz[0]), np.inf, np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.abs(simpler - exact) / np.abs(exact)
        change = np.abs(20 * np.log10(np.abs(simpler) / np.abs(exact)))
    k = int(np.argmax(relative))
    weight = band.weight(hertz)
    rms = np.sqrt(np.sum(weight * np.abs(simpler - exact) ** 2) / np.sum(weight * np.abs(exact) ** 2))
    return Cost(float(relative[k]), float(hertz[k]), float(change.max()), float(rms))
