"""Search of shape parameters: characteristic speeds and angle orders, found and not given."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.observation import Observation
from symdyn.spec.effect_schema import Scan

Array = NDArray[np.float64]

SPEEDS = 24  # grid points over the speeds that occur
HIGHEST_ORDER = 64  # waves per turn; gears with more teeth need a finer encoder than most
WAVES = 2.0  # that the travel must hold: what does not repeat cannot be called periodic
STEPS_PER_TURN = 2  # orders between the integers are tried where the travel can tell them apart


def grid(candidate: Candidate, joint: int, observation: Observation, cutoff: float) -> Array:
    """Values of the shape parameter to try; one dummy value for effects without any."""
    if candidate.shape is None:
        return np.ones(1)
    speed = np.abs(observation.qd[:, joint])
    if candidate.shape.scan is Scan.SPEED:
        top = float(np.quantile(speed, 0.99))
        return np.geomspace(top / 200.0, top, SPEEDS) if top > 0 else np.ones(1)
    # An order whose ripple passes faster than the band edge at half the usual speed cannot be seen.
    usual = float(np.median(speed))
    highest = min(HIGHEST_ORDER, 2.0 * np.pi * cutoff / max(usual / 2.0, 1e-9))
    travel = float(np.ptp(observation.q[:, joint])) / (2.0 * np.pi)
    finest = 1.0 if travel < 1.0 else 1.0 / STEPS_PER_TURN
    lowest = max(1.0, WAVES / max(travel, 1e-9))
    return np.arange(np.ceil(lowest), max(highest, lowest + 1.0), finest)
