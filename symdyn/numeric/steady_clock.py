"""Samples of a clock that trembles, brought to even steps."""

from __future__ import annotations

import math
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from symdyn.numeric.position_spectrum import floor
from symdyn.numeric.recording import ChannelKey, Recording
from symdyn.spec.records import Quantity

Array = NDArray[np.float64]

UNEVEN = 1e-3  # of a step, root mean square: less leaves nothing
BELIEVED = 0.5  # of the power: times are those of the samples unless positions tremble less than that without them
TINY = 1e-300


def steady(recording: Recording) -> Recording:
    """All channels at even times of each stretch.

    Filters and derivatives take steps for equal. A time is that of its sample, which is then looked for on a cubic
    spline; or it is that of when an even sample was written down, where by that positions tremble much less (the
    product of their floors).
    """
    steps = np.concatenate([np.diff(recording.time[part]) for part in recording.segments])
    step = float(np.mean(steps))
    shown = [key for key in recording.channels if key[0] is Quantity.POSITION]
    if not shown or float(np.std(steps)) < UNEVEN * step:
        return recording
    ways = _between(recording, step), _as_if_even(recording)
    floors = [floor(np.column_stack([each.channels[key] for key in shown]), each.segments, 1.0 / step) for each in ways]
    gain = float(np.mean(np.log(floors[1] + TINY) - np.log(floors[0] + TINY)))
    return ways[int(gain < math.log(BELIEVED))]


def _between(recording: Recording, step: float) -> Recording:
    times: list[Array] = []
    segments: list[slice] = []
    channels: dict[ChannelKey, list[Array]] = {key: [] for key in recording.channels}
    for part in recording.segments:
        time = recording.time[part]
        count = int((time[-1] - time[0]) / step) + 1
        at = time[0] + step * np.arange(count)
        start = segments[-1].stop if segments else 0
        segments.append(slice(start, start + count))
        times.append(at)
        for key, values in recording.channels.items():
            channels[key].append(CubicSpline(time, values[part])(at) if len(time) > 1 else values[part])
    joined = MappingProxyType({key: np.concatenate(parts) for key, parts in channels.items()})
    return replace(recording, time=np.concatenate(times), channels=joined, segments=tuple(segments), sample_time=step)


def _as_if_even(recording: Recording) -> Recording:
    time, steps = recording.time.copy(), []
    for part in recording.segments:
        time[part] = np.linspace(time[part][0], time[part][-1], part.stop - part.start)
        steps += [(time[part][-1] - time[part][0]) / max(part.stop - part.start - 1, 1)]
    return replace(recording, time=time, sample_time=float(np.mean(steps)))
