"""What can be wrong with the numbers of a recording: time, gaps, units, signs, idle channels."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import Problem, Where
from symdyn.spec.records import Channel, Quantity

Samples = NDArray[np.float64]
PlaceOfRow = Callable[[int], Where]
Segments = tuple[slice, ...]

MIN_SAMPLES = 200
GAP_STEPS = 5.0  # a step longer than this many median steps is a gap
MAX_LOST_SHARE = 0.2  # of the time span, within gaps
SLOWEST_STEP, ABSURD_STEP, FASTEST_STEP = 0.5, 100.0, 2e-6  # s
MAX_LISTED = 10

_WINDOW = 16  # samples over which a change of position is held against the integral of velocity
_KNOWN_RATIOS = (
    (180 / math.pi, "the position is in degrees where the velocity is in rad/s"),
    (math.pi / 180, "the velocity is in deg/s where the position is in rad"),
    (math.pi / 30, "the velocity is in rev/min"),
    (2 * math.pi, "the velocity is in rev/s"),
    (1e3, "the position is in mm where the velocity is in m/s"),
    (1e-3, "the time is in ms, or the velocity in mm/s"),
    (1e-6, "the time is in us"),
    (1e-9, "the time is in ns"),
)


def check_time(time: Samples, column: str, where: PlaceOfRow, lines: NDArray[np.int64]) -> list[Problem]:
    """SD501 time runs backwards, SD502 it stands still, SD506 its unit cannot be, SD508 too few samples."""
    problems = []
    if len(time) < MIN_SAMPLES:
        message = f"{len(time)} samples; at least {MIN_SAMPLES} are needed"
        problems.append(Problem("SD508", message, where(len(time) - 1), "record for longer"))
    if len(time) < 2:
        return problems
    steps = np.diff(time)
    back = np.flatnonzero(steps < 0) + 1
    if back.size:
        first = int(back[0])
        message = f"time runs backwards: '{column}' is {time[first]:.9g} s after {time[first - 1]:.9g} s"
        message += f" (the first of {back.size} such rows)" if back.size > 1 else ""
        hint = "sort the rows by time; or, where a clock was set anew, cut the file into two recordings"
        problems.append(Problem("SD501", message, where(first), hint))
    still = np.flatnonzero(steps == 0) + 1
    if still.size:
        listed = ", ".join(str(lines[row]) for row in still[:MAX_LISTED]) + (", ..." if still.size > MAX_LISTED else "")
        message = f"{still.size} row{'s repeat' if still.size > 1 else ' repeats'} the time of the row before: {listed}"
        hint = "remove them; or write the time with more digits, where those were cut off"
        problems.append(Problem("SD502", message, where(int(still[0])), hint))
    if (median := float(np.median(steps))) > ABSURD_STEP:
        message = f"the median step of '{column}' is {median:.4g} s, which is no recording of a machine"
        problems.append(Problem("SD506", message, where(0), 'write the unit of time: unit = "ms", "us" or "ns"'))
    return problems


def split_at_gaps(time: Samples, where: PlaceOfRow) -> tuple[Segments, list[Problem], list[Problem]]:
    """Slices without gaps; SD503 as an error when gaps leave too little, else as a warning for each gap."""
    steps = np.diff(time)
    median = float(np.median(steps))
    before = np.flatnonzero(steps > GAP_STEPS * median)
    ends = [0, *(int(row) + 1 for row in before), len(time)]
    segments = tuple(slice(start, stop) for start, stop in pairwise(ends))
    errors = []
    if before.size:
        first = where(int(before[0]) + 1)
        lost = float(np.sum(steps[before])) / float(time[-1] - time[0])
        longest = max(part.stop - part.start for part in segments)
        told = f"{before.size} gap{'s' if before.size > 1 else ''} of more than {GAP_STEPS:g} steps of {median:.4g} s"
        if lost > MAX_LOST_SHARE:
            message = f"{told}: {100 * lost:.0f} % of the time span is lost"
            errors.append(Problem("SD503", message, first, "cut the file at its gaps and use the longest part"))
        if longest < MIN_SAMPLES <= len(time):
            message = f"{told}: the longest part without one has {longest} samples, {MIN_SAMPLES} are needed"
            errors.append(Problem("SD503", message, first, "record again without losing samples"))
    warnings = []
    for row in before[:MAX_LISTED]:
        message = f"a gap of {steps[row]:.4g} s after {time[row]:.6g} s splits the recording"
        warnings.append(Problem("SD503", message, where(int(row) + 1)))
    if before.size > MAX_LISTED:
        message = f"and {before.size - MAX_LISTED} more gaps"
        warnings.append(Problem("SD503", message, where(int(before[MAX_LISTED]) + 1)))
    if median > SLOWEST_STEP or median < FASTEST_STEP:
        unit = "ms" if median > SLOWEST_STEP else "s"
        hint = f'if the column is in {unit}, write unit = "{unit}" for the time'
        warnings.append(Problem("SD506", f"the median time step is {median:.4g} s", where(0), hint))
    return segments, errors, warnings


def check_channels(
    time: Samples, segments: Segments, measured: Sequence[tuple[Channel, Samples]], places: Mapping[Channel, Where]
) -> tuple[list[Problem], list[Problem]]:
    """Errors and warnings on units (SD506), velocity against position (SD507), idle channels (SD508)."""
    errors: list[Problem] = []
    warnings: list[Problem] = []
    positions = {(c.joint, c.side): (c, values) for c, values in measured if c.quantity is Quantity.POSITION}
    for channel, values in measured:
        where = places[channel]
        if np.ptp(values) == 0.0:
            message = f"channel '{channel.column}' is constant ({values[0]:.6g}): it tells nothing"
            warnings.append(Problem("SD508", message, where))
        elif channel.quantity is Quantity.POSITION and channel.unit == "rad":
            warnings += _suspect_degrees(channel, values, where)
        if channel.quantity is Quantity.VELOCITY and (channel.joint, channel.side) in positions:
            reference, position = positions[channel.joint, channel.side]
            found, blatant = _compare(_movement(time, segments, position, values), channel, reference, where)
            (errors if blatant else warnings).extend(found)
    return errors, warnings


def _suspect_degrees(channel: Channel, values: Samples, where: Where) -> list[Problem]:
    largest = float(np.max(np.abs(values)))
    if largest <= 4 * math.pi:
        return []
    message = f"'{channel.column}' reaches {largest:.4g} rad, more than two turns"
    return [Problem("SD506", message, where, 'if the column is in degrees, write unit = "deg"')]


def _compare(
    movement: tuple[Samples, Samples], channel: Channel, reference: Channel, where: Where
) -> tuple[list[Problem], bool]:
    """SD507 when a velocity is not the derivative of the position; the flag says that this is beyond doubt."""
    increments, integrals = movement
    moved = math.sqrt(float(increments @ increments) * float(integrals @ integrals))
    if moved == 0.0:
        return [], False
    correlation = float(increments @ integrals) / moved
    names = f"velocity '{channel.column}' is not the derivative of position '{reference.column}'"
    if abs(correlation) <= 0.9:
        message = f"{names}: their correlation is {correlation:.2f}"
        return [Problem("SD507", message, where, "check what the two columns hold")], False
    # of the two norms, not of a regression: noise in either signal biases it little
    size = math.sqrt(float(increments @ increments) / float(integrals @ integrals))
    if correlation > 0 and 0.8 <= size <= 1.25:
        return [], False
    ratio = math.copysign(size, correlation)
    message = f"{names}: the derivative is {ratio:.4g} times the velocity (correlation {correlation:.3f})"
    fixes = []
    if ratio < 0:
        fixes.append(f"sign = {-channel.sign}")
    if not 0.8 <= size <= 1.25:
        fixes.append(f"scale = {channel.scale * size:.6g}")
        message += next((f"; maybe {text}" for known, text in _KNOWN_RATIOS if abs(size / known - 1) < 0.1), "")
    hint = f"for '{channel.column}' write {' and '.join(fixes)}; or correct '{reference.column}' or the unit of time"
    return [Problem("SD507", message, where, hint)], True


def _movement(time: Samples, segments: Segments, position: Samples, velocity: Samples) -> tuple[Samples, Samples]:
    """Changes of position, and integrals of velocity, over windows within the segments.

    Against windows, so that no noisy signal is differentiated.
    """
    changes, integrals = [np.zeros(0)], [np.zeros(0)]
    for part in segments:
        v, step = velocity[part], np.diff(time[part])
        window = min(_WINDOW, len(step))
        if window:
            path = np.concatenate(([0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * step)))
            changes.append(position[part][window:] - position[part][:-window])
            integrals.append(path[window:] - path[:-window])
    return np.concatenate(changes), np.concatenate(integrals)
