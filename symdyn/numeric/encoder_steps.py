"""The steps of an encoder, read off the positions that it showed: their size, and what rounding to them does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.observation import smoothed
from symdyn.numeric.position_spectrum import FLOOR_MARGIN, spectrum
from symdyn.numeric.recording import ChannelKey, Recording
from symdyn.numeric.recording_quality import steps_of

Array = NDArray[np.float64]

MOSTLY = 0.5  # of the power of what trembles in the positions
APART = (3.0 - 3.0**0.5) / 6.0  # of a step: rounding errors that far apart on the scale are not correlated
ROUNDS = 5  # of the search of where a motion sinks into the steps
NOTHING = 1e-30  # of the largest power
SLOWEST = 4  # bins of a spectrum: where that search begins


@dataclass(frozen=True, slots=True)
class Steps:
    """``motion`` is the frequency (Hz) above which the motion shown is less than what rounding makes of it."""

    size: float
    standard_error: float
    motion: float


def coarse(recording: Recording, key: ChannelKey) -> Steps | None:
    """The steps that positions lie on; None where there are none, or the positions tremble by more than their steps.

    What trembles is what is quicker than the motion; rounding the motion to such steps must account for most of it.
    """
    shown = recording.channels[key]
    found = steps_of(shown)
    if found is None:
        return None
    motion, rate = motion_above(recording, key, found[0]), 1.0 / recording.sample_time
    ways = shown, rounded(recording, key, found[0], motion)[1]
    noise, own = (x - smoothed(x, recording.segments, rate, motion) for x in ways)
    return None if np.sum(own**2) < MOSTLY * np.sum(noise**2) else Steps(*found, motion)


def motion_above(recording: Recording, key: ChannelKey, size: float) -> float:
    """Hz up to which the positions shown stand above what rounding does to them.

    Rounding is no white noise: of a slow joint it is slow. So its spectrum is that of the motion itself, rounded.
    """
    rate = 1.0 / recording.sample_time
    longest = max(recording.segments, key=lambda part: part.stop - part.start)
    frequency, shown = spectrum(recording.channels[key][longest], rate)
    motion = float(frequency[SLOWEST])
    for _ in range(ROUNDS):
        smooth, steps = rounded(recording, key, size, motion)
        _, own = spectrum((steps - smooth)[longest], rate)
        over = shown / np.maximum(own, NOTHING * shown.max())
        clearest = int(np.argmax(over))  # below it the slow part of either leaks over the rest
        sunk = clearest + np.flatnonzero(over[clearest:] <= FLOOR_MARGIN)
        motion, before = float(frequency[sunk[0]] if len(sunk) else frequency[-1]), motion
        if motion == before:
            break
    return motion


def rounded(recording: Recording, key: ChannelKey, size: float, motion: float) -> tuple[Array, Array]:
    """(N,) the positions below a frequency, and those rounded to another scale with the same steps.

    Their difference is like what the encoder's own rounding did: a sawtooth, whose power is where it is, however slowly
    the joint turns.
    """
    smooth = smoothed(recording.channels[key], recording.segments, 1.0 / recording.sample_time, motion)
    return smooth, (np.round(smooth / size + APART) - APART) * size
