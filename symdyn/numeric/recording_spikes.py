"""Single samples that a sensor or a bus got wrong: far from those on either side, which agree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import Problem, Where
from symdyn.numeric.recording_quality import steps_of
from symdyn.numeric.recording_time import Samples, Segments
from symdyn.spec.records import Channel, Quantity

AROUND = 5  # samples whose median is what a sample should be near: it passes a jump, and two spikes
AGREE = 0.25  # of its distance from that, what three of the five have at most
FAR = 20.0  # times what 99 of 100 samples are away from that
LEAST = 0.02  # of the range that 98 of 100 samples have
RARE = 0.002  # of the samples: what is more frequent is no mistake of a bus
SENSED = (Quantity.POSITION, Quantity.VELOCITY, Quantity.EFFORT, Quantity.CURRENT)  # a voltage may jump at will


def without_spikes(
    channel: Channel, column: Samples, segments: Segments, where: Where
) -> tuple[Samples, list[Problem]]:
    """The column with spikes replaced by what lies between their neighbours, and a warning (SD534) if it has any."""
    if channel.quantity not in SENSED:
        return column, []
    away, apart = np.zeros((2, len(column)))
    for part in segments:
        inner = slice(part.start + AROUND // 2, part.stop - AROUND // 2)  # an end has neighbours on one side alone
        if inner.stop > inner.start:
            near = np.lib.stride_tricks.sliding_window_view(column[part], AROUND)
            off = np.abs(near - np.median(near, axis=1, keepdims=True))
            away[inner], apart[inner] = off[:, AROUND // 2], np.sort(off, axis=1)[:, AROUND // 2]
    low, high = np.quantile(column, (0.01, 0.99))
    agreed = apart < AGREE * away
    spikes = agreed & (away > max(FAR * float(np.quantile(away, 0.99)), LEAST * float(high - low)))
    count = int(np.count_nonzero(spikes))
    if not 0 < count <= RARE * len(column) or high == low:
        return column, []
    good = np.flatnonzero(~spikes)
    message = f"{count} sample{'s' if count > 1 else ''} of '{channel.column}' stand{'s' if count == 1 else ''} alone"
    message += f", by up to {float(away[spikes].max()):.3g} {channel.unit}" if channel.scale == 1.0 else ""
    hint = "nothing: what lies between its neighbours was taken instead; or see what the sensor's bus loses"
    return _filled(column, good), [Problem("SD534", message, where, hint)]


def _filled(column: Samples, good: NDArray[np.int64]) -> Samples:
    """(N,) the good samples, and between them what lies there; of a sensor with steps, one of its steps."""
    filled = np.interp(np.arange(len(column)), good, column[good])
    if steps_of(column[good]) is not None:
        levels = np.unique(column[good])
        middles = 0.5 * (levels[1:] + levels[:-1])
        filled = levels[np.searchsorted(middles, filled)]
    return filled
