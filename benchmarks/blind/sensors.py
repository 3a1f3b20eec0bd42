"""What sensors make of the truth: sampling, noise and steps, at three levels, and their own concealed faults."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.blind.motions import CONTROL

TACHO_CONSTANT = 0.029  # V s/rad


@dataclass(frozen=True)
class Level:
    """How good the sensors are; noise is a standard deviation."""

    rate: int  # Hz, of the recording
    encoder_counts: int  # per turn
    encoder_noise: float  # rad
    noise: float  # of every other channel, over its full range
    bits: int  # of every other channel: steps in four times its full range

    @property
    def stride(self) -> int:
        """Control samples per recorded sample."""
        return round(1 / (CONTROL * self.rate))


LEVELS = {
    "low": Level(1000, 2**20, 3e-6, 0.001, 14),
    "middle": Level(500, 2**18, 1e-5, 0.005, 12),
    "high": Level(250, 2**15, 5e-5, 0.02, 10),
}


def encoder(angle: np.ndarray, level: Level) -> np.ndarray:
    """Angles, noise included, in the steps of an encoder."""
    step = 2 * math.pi / level.encoder_counts
    return step * np.round(angle / step)


def analogue(value: np.ndarray, full: float, level: Level, rng: np.random.Generator) -> np.ndarray:
    """A voltage, current or torque as a converter shows it; its range is wide enough for whatever comes."""
    step = 4.0 * full / 2**level.bits
    return step * np.round((value + level.noise * full * rng.standard_normal(value.shape)) / step)


def faulty(value: np.ndarray, fault: Mapping[str, float]) -> np.ndarray:
    """A channel, one value per control sample, with gain, offset, lag, lateness (s) and steps, as far as given."""
    shown = fault.get("gain", 1.0) * value + fault.get("offset", 0.0)
    lag = fault.get("lag", 0.0)
    if lag:
        keep = math.exp(-CONTROL / lag)
        out = np.empty_like(shown)
        state = shown[0]
        for k, new in enumerate(shown):
            out[k] = state
            state = keep * state + (1.0 - keep) * 0.5 * (new + shown[min(k + 1, len(shown) - 1)])
        shown = out
    late = fault.get("late", 0.0)
    if late:
        time = CONTROL * np.arange(len(shown))
        shown = np.interp(time - late, time, shown)
    step = fault.get("resolution", 0.0)
    return step * np.round(shown / step) if step else shown
