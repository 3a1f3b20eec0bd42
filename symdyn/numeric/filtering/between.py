"""What an input does between two samples: kept, gone straight to the next, or without what is quicker than samples."""

from __future__ import annotations

from enum import Enum
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d
from scipy.signal import firwin2

Array = NDArray[np.float64]

TAPS = 65
MATTERS = 0.01  # of how far an input moves: where it is nearly straight between samples, there is nothing to choose


class Between(Enum):
    """HELD: a converter's. STRAIGHT: to the next sample. BANDED: a signal that was filtered before it was sampled."""

    HELD = "held"
    STRAIGHT = "straight"
    BANDED = "banded"

    @property
    def other(self) -> Between:
        return Between.STRAIGHT if self is Between.HELD else Between.HELD


def nodes(u: Array, steps: Array) -> Array:
    """(N, nu) between which straight lines have, below half the sampling rate, the spectrum of a band-limited input.

    A line through samples u (N, nu) of such an input damps a frequency f by sinc^2(f / rate): a tenth at a fifth of the
    rate. So they are filtered by its inverse first. What the lines bring above half the rate, a machine hardly follows.
    ``steps`` (N,) is nan where a run ends.
    """
    found = u.copy()
    ends = np.flatnonzero(np.isnan(steps)) + 1
    for first, last in zip((0, *ends[:-1]), ends, strict=True):
        found[first:last] = convolve1d(u[first:last], _inverse(), axis=0, mode="nearest")
    return found


def matters(u: Array, steps: Array) -> bool:
    """Whether that differs from the samples, of an even clock; only then its filter means anything."""
    known = steps[~np.isnan(steps)]
    if not len(known) or np.ptp(known) > 0.0:
        return False
    moved = np.std(u, axis=0)
    return bool(np.any(np.std(nodes(u, steps) - u, axis=0) > MATTERS * moved))


@cache
def _inverse() -> Array:
    frequency = np.linspace(0.0, 1.0, 257)  # of half the rate
    found = np.asarray(firwin2(TAPS, frequency, 1.0 / np.sinc(0.5 * frequency) ** 2))
    return np.asarray(found / found.sum())  # what is constant stays so
