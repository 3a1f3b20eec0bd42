"""What the machines are told to do: sums of sines with random phases, other ones for training and for judging."""

from __future__ import annotations

import math

import numpy as np

CONTROL = 1e-3  # s: the sample time of every controller
WIND_UP = 0.02  # rad: beyond this error a controller of an arm does not integrate
HARMONICS = ((1, 2, 3, 5, 7), (1, 2, 4, 5, 8))  # of the training run, of the held-out run
FUNDAMENTAL = (0.1, 0.085)  # Hz


def rng_of(*words: object) -> np.random.Generator:
    """A generator that depends on the words alone, the same on every machine."""
    text = "/".join(str(word) for word in words)
    return np.random.default_rng(list(text.encode("utf-8")))


def multisine(rng: np.random.Generator, run: int, duration: float, centre: np.ndarray, reach: np.ndarray):
    """Positions and speeds to follow, each (N, n), one row per control sample; |x - centre| stays below ``reach``."""
    time = CONTROL * np.arange(round(duration / CONTROL))
    order = np.array(HARMONICS[run])
    omega = 2 * math.pi * FUNDAMENTAL[run] * order
    period = np.arange(0.0, 1.0 / FUNDAMENTAL[run], 10 * CONTROL)
    x, v = np.empty((len(time), len(centre))), np.empty((len(time), len(centre)))
    for joint in range(len(centre)):
        weight = rng.uniform(0.4, 1.0, len(order))
        phase = rng.uniform(0.0, 2 * math.pi, len(order))
        weight *= reach[joint] / np.max(np.abs(np.sin(np.outer(period, omega) + phase) @ weight))
        x[:, joint] = centre[joint] + np.sin(np.outer(time, omega) + phase) @ weight
        v[:, joint] = np.cos(np.outer(time, omega) + phase) @ (weight * omega)
    return x, v
