"""Signals of an experiment, with their derivatives: a sweep to and fro, a Fourier series, from rest to rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Three = tuple[Array, Array, Array]  # a signal (N,) with its first two derivatives

BLEND = 0.12  # of a phase: the time in which its motion is brought in from rest, and out
TURN = 0.15  # of a sweep's half period: the time in which it turns round


def fourier_series(time: Array, frequency: float, coefficients: Array) -> Three:
    """A finite Fourier series; ``coefficients`` (2, H) of cosines and sines, from 0 to 1 for -1 to 1."""
    a, b = 2.0 * coefficients - 1.0
    omega = 2.0 * np.pi * frequency * np.arange(1, len(a) + 1)
    angle = np.outer(time, omega)
    cosine, sine = np.cos(angle), np.sin(angle)
    return (
        cosine @ a + sine @ b,
        sine @ (-a * omega) + cosine @ (b * omega),
        -(cosine @ (a * omega**2) + sine @ (b * omega**2)),
    )


def triangle(time: Array, frequency: float) -> Three:
    """To and fro at constant speed; each turn is a smooth step of the speed. From the centre upwards."""
    half = 0.5 / frequency  # a turn, and the run after it
    turn = TURN * half
    shifted = time + (half + turn) / 2  # since the beginning of a turn
    number = np.floor(shifted / half)
    since = shifted - number * half
    step, rate, integral = _smooth(np.clip(since / turn, 0.0, 1.0))
    turning = since < turn
    along = np.where(turning, turn * 2.0 * integral - since, since - turn)  # a turn ends where it began
    sign = np.where(number % 2 == 0, 1.0, -1.0)
    return (
        sign * (along - (half - turn) / 2),
        sign * (2.0 * step - 1.0),
        sign * np.where(turning, 2.0 * rate / turn, 0.0),
    )


def _smooth(u: Array) -> Three:
    """The quintic step from 0 to 1, its rate, and its integral from 0."""
    step = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    return step, 30.0 * u**2 * (1.0 - u) ** 2, u**4 * (2.5 - 3.0 * u + u**2)


def brought_in(shape: Three, time: Array, duration: float) -> Three:
    """The shape times an envelope that starts and ends at zero with zero rate and zero curvature."""
    blend = BLEND * duration
    u = np.clip(np.minimum(time, duration - time) / blend, 0.0, 1.0)
    sign = np.where(time < duration / 2, 1.0, -1.0)
    w, rate, _ = _smooth(u)
    w1, w2 = sign * rate / blend, 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / blend**2
    x, x1, x2 = shape
    return w * x, w * x1 + w1 * x, w * x2 + 2.0 * w1 * x1 + w2 * x
