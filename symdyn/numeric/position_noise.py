"""The noise of measured positions: its level, and what it makes of a speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.observation import Observation
from symdyn.numeric.position_spectrum import floor

Array = NDArray[np.float64]


def position_density(observation: Observation) -> Array:
    """(n,) power density of each position's noise per hertz."""
    return floor(observation.measured, observation.segments, observation.rate)


def speed_noise(observation: Observation, motions: Array | None = None) -> Array:
    """(n,) standard deviation of the noise in ``observation.qd``: the position's, differentiated, below ``motions``."""
    o = observation
    edges = o.motions if motions is None else motions
    return np.asarray(np.sqrt(position_density(o) * (2.0 * np.pi) ** 2 * edges**3 / 3.0))
