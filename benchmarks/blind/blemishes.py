"""What may be wrong with a recording itself: its clock, its rows, its units and signs. The plant is as it was.

Some of it a tool can put right, or leave out: then the answer must be that of the sound recording. The rest makes the
channels other quantities than the model handed over says: then any physics that is told is false.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from benchmarks.blind.machine import Recorded
from benchmarks.blind.planting import Planted

UNEVEN = 0.1  # standard deviation of instants, in steps
START = 0.02  # s: time constant of a filter that started from zero
REPEATED = 2
STRAY, LOST = 5, 0.005  # single samples of each position; share of rows
STILL = 0.4  # s at the end, in which the file repeats the last row
CLIPPED = 0.6  # of an effort's range

Spoil = Callable[[np.random.Generator, Recorded], Recorded]


def uneven_clock(rng: np.random.Generator, recorded: Recorded) -> Recorded:
    """Recorded at instants that tremble; the time stamps are right."""
    time = recorded.time
    stamps = _trembling(rng, recorded)
    return replace(recorded, time=stamps, columns=_each(recorded, "", lambda value: CubicSpline(time, value)(stamps)))


def trembling_stamps(rng: np.random.Generator, recorded: Recorded) -> Recorded:
    """Recorded at even instants, and stamped late and early."""
    return replace(recorded, time=_trembling(rng, recorded))


def turned_angles(_: np.random.Generator, recorded: Recorded) -> Recorded:
    """Angles from 0 to one turn, at which they start again."""
    return replace(recorded, columns=_each(recorded, "x", lambda value: np.mod(value, 2.0 * math.pi)))


def repeated_rows(_: np.random.Generator, recorded: Recorded) -> Recorded:
    """The file is written more often than the channels are read."""
    columns = _each(recorded, "", lambda value: np.repeat(value, REPEATED))
    return Recorded.even(float(recorded.time[1]) / REPEATED, columns)


def stray_samples(rng: np.random.Generator, recorded: Recorded) -> Recorded:
    """Single samples of a position that stand alone."""

    def stray(value: np.ndarray) -> np.ndarray:
        where = rng.choice(len(value) - 2, STRAY, replace=False) + 1
        out = value.copy()
        out[where] += np.ptp(value) * rng.uniform(0.5, 2.0, STRAY) * rng.choice((-1.0, 1.0), STRAY)
        return out

    return replace(recorded, columns=_each(recorded, "x", stray))


def lost_rows(rng: np.random.Generator, recorded: Recorded) -> Recorded:
    """Single rows are missing."""
    kept = rng.random(len(recorded.time)) >= LOST
    return replace(recorded, time=recorded.time[kept], columns=_each(recorded, "", lambda value: value[kept]))


def filter_start(_: np.random.Generator, recorded: Recorded) -> Recorded:
    """Every channel went through a filter that started from zero."""
    rise = 1.0 - np.exp(-recorded.time / START)
    return replace(recorded, columns=_each(recorded, "", lambda value: rise * value))


def still_end(_: np.random.Generator, recorded: Recorded) -> Recorded:
    """The sensors stop before the file does: its last rows repeat one."""
    last = int(np.searchsorted(recorded.time, recorded.time[-1] - STILL))

    def stopped(value: np.ndarray) -> np.ndarray:
        return np.where(np.arange(len(value)) < last, value, value[last])

    return replace(recorded, columns=_each(recorded, "", stopped))


def flipped_efforts(_: np.random.Generator, recorded: Recorded) -> Recorded:
    return replace(recorded, columns=_each(recorded, "y", np.negative))


def flipped_position(_: np.random.Generator, recorded: Recorded) -> Recorded:
    return replace(recorded, columns=_each(recorded, "x1", np.negative))


def exchanged_efforts(_: np.random.Generator, recorded: Recorded) -> Recorded:
    columns = dict(recorded.columns)
    return replace(recorded, columns={**columns, "y1": columns["y2"], "y2": columns["y1"]})


def degrees(_: np.random.Generator, recorded: Recorded) -> Recorded:
    """Angles in degrees, where the model says rad."""
    return replace(recorded, columns=_each(recorded, "x", np.degrees))


def milliseconds(_: np.random.Generator, recorded: Recorded) -> Recorded:
    """Time in ms, where the model says s."""
    return replace(recorded, time=1e3 * recorded.time)


def clipped_efforts(_: np.random.Generator, recorded: Recorded) -> Recorded:
    """Sensors of too small a range."""

    def clip(value: np.ndarray) -> np.ndarray:
        middle, half = 0.5 * (value.max() + value.min()), 0.5 * CLIPPED * np.ptp(value)
        return np.clip(value, middle - half, middle + half)

    return replace(recorded, columns=_each(recorded, "y", clip))


def _trembling(rng: np.random.Generator, recorded: Recorded) -> np.ndarray:
    step = float(recorded.time[1] - recorded.time[0])
    off = np.clip(UNEVEN * rng.standard_normal(len(recorded.time)), -4.0 * UNEVEN, 4.0 * UNEVEN)
    off[0] = off[-1] = 0.0
    return recorded.time + step * off


def _each(recorded: Recorded, start: str, change: Callable[[np.ndarray], np.ndarray]) -> dict[str, np.ndarray]:
    """The columns, those whose name begins so changed."""
    return {name: change(value) if name.startswith(start) else value for name, value in recorded.columns.items()}


BLEMISHES: Mapping[str, Spoil] = {
    spoil.__name__: spoil
    for spoil in (
        uneven_clock, trembling_stamps, turned_angles, repeated_rows, stray_samples, lost_rows, filter_start, still_end,
        flipped_efforts, flipped_position, exchanged_efforts, degrees, milliseconds, clipped_efforts,
    )
}  # fmt: skip
REFUSED: Mapping[str, tuple[str, ...]] = {  # by the codes of problems that tell what is wrong; the others are mended
    "flipped_efforts": ("SD533",),
    "flipped_position": ("SD533",),
    "exchanged_efforts": ("SD533",),
    "degrees": ("SD506", "SD507"),
    "milliseconds": ("SD506",),
    "clipped_efforts": ("SD524",),
}


def blemish(kind: str) -> Planted:
    """As a planted effect: one of no place and no name."""
    return Planted(kind, "", problems=REFUSED.get(kind, ()), blemish=True)
