"""What can be wrong with the clock of a recording: order, repeats, gaps, jitter, unit."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import Problem, Where

Samples = NDArray[np.float64]
PlaceOfRow = Callable[[int], Where]
Segments = tuple[slice, ...]

MIN_SAMPLES = 200
GAP_STEPS = 5.0  # a step longer than this many median steps is a gap
MAX_LOST_SHARE = 0.2  # of the time span, within gaps
SLOWEST_STEP, ABSURD_STEP, FASTEST_STEP = 0.5, 100.0, 2e-6  # s
JITTER, WILD_JITTER = 0.1, 0.4  # mean deviation of the steps from their median, in median steps
MAX_LISTED = 10


def check_time(time: Samples, column: str, where: PlaceOfRow, lines: NDArray[np.int64]) -> list[Problem]:
    """SD501 time runs backwards, SD502 it stands still, SD506 its unit cannot be, SD508 too few samples."""
    problems = []
    if len(time) < MIN_SAMPLES:
        message = f"{len(time)} samples; at least {MIN_SAMPLES} are needed"
        problems.append(Problem("SD508", message, where(len(time) - 1), "record for longer"))
    if len(time) < 2:
        return problems
    problems += check_order(time, column, where, lines)
    if (median := float(np.median(np.diff(time)))) > ABSURD_STEP:
        message = f"the median step of '{column}' is {median:.4g} s, which is no recording of a machine"
        problems.append(Problem("SD506", message, where(0), 'write the unit of time: unit = "ms", "us" or "ns"'))
    return problems


def check_order(time: Samples, column: str, where: PlaceOfRow, lines: NDArray[np.int64]) -> list[Problem]:
    """SD501 time runs backwards, SD502 it stands still; two samples and more."""
    problems = []
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
    return problems


def split_at_gaps(time: Samples, where: PlaceOfRow) -> tuple[Segments, list[Problem], list[Problem]]:
    """Slices without gaps; SD503 as an error when gaps leave too little, else a warning for each; SD509 jitter."""
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
    ordinary = steps[steps <= GAP_STEPS * median]
    if (jitter := float(np.mean(np.abs(ordinary - median))) / median) > JITTER:
        message = f"the clock jitters: steps of {median:.4g} s are off by {100 * jitter:.0f} % on average"
        hint = "record with a steady clock; samples are brought to even steps as well as these times tell"
        (errors if jitter > WILD_JITTER else warnings).append(Problem("SD509", message, where(1), hint))
    if median > SLOWEST_STEP or median < FASTEST_STEP:
        unit = "ms" if median > SLOWEST_STEP else "s"
        hint = f'if the column is in {unit}, write unit = "{unit}" for the time'
        warnings.append(Problem("SD506", f"the median time step is {median:.4g} s", where(0), hint))
    return segments, errors, warnings
