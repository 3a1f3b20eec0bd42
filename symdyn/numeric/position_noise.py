"""What the noise of measured positions makes of a speed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.observation import Observation

Array = NDArray[np.float64]


def speed_noise(observation: Observation, motions: Array | None = None) -> Array:
    """(n,) standard deviation of the noise in ``observation.qd``: the position's, differentiated, below ``motions``."""
    o = observation
    edges = o.motions if motions is None else motions
    return np.asarray(np.sqrt(o.noise * (2.0 * np.pi) ** 2 * edges**3 / 3.0))
