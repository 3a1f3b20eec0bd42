"""What a recording repeats: whole turns that an encoder takes back, and rows that a logger wrote twice."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import Problem, Where
from symdyn.numeric.recording_time import Samples
from symdyn.spec.records import Channel, Quantity

ANGLES = ("rad", "deg", "rev")
REPEATED = 0.3  # of the rows, from which on a logger is taken to be quicker than what it logs
TOGETHER = 20  # runs of equal rows in a row, which are as long as any other so many:
REGULAR = 0.8  # of them
OFF = 2.5  # rows by which they may differ. What coarse steps repeat is of any length, and would differ by more
REST = 3.0  # times as long as most: nothing moved


def fresh_rows(columns: Sequence[Samples]) -> tuple[NDArray[np.int64], int]:
    """Rows to keep, and how often each value was written: 1 where rows are not repeated regularly.

    A row of a moving machine with noise is not the same as the one before, in every column, unless it is old. Where the
    machine rests rows are alike for longer, and one of as many is kept.
    """
    count = len(columns[0])
    same = np.all([values[1:] == values[:-1] for values in columns], axis=0)
    starts = np.concatenate([[0], np.flatnonzero(~same) + 1])
    lengths = np.diff(np.append(starts, count))
    times = int(np.median(lengths))
    ordinary = lengths[lengths <= REST * times]
    if times < 2 or len(ordinary) < TOGETHER or same.mean() < REPEATED or not _is_regular(ordinary):
        return np.arange(count), 1
    since = np.arange(count) - np.repeat(starts, lengths)
    ends = np.repeat(np.maximum(lengths - times // 2, 1), lengths)  # a run that is longer by one is no second sample
    return np.flatnonzero((since % times == 0) & (since < ends)), times


def _is_regular(lengths: NDArray[np.int64]) -> bool:
    sums = np.convolve(lengths, np.ones(TOGETHER), mode="valid")
    return float(np.mean(np.abs(sums - np.median(sums)) <= OFF)) >= REGULAR


def check_repeats(times: int, where: Where) -> list[Problem]:
    """SD532: rows that are no samples were left out."""
    if times == 1:
        return []
    message = f"every sample is written {times} times: the machine was read less often than the rows say"
    return [Problem("SD532", message, where, "nothing: the first of each is taken; or record what is new")]


def unwrapped(channel: Channel, column: Samples, where: Where) -> tuple[Samples, list[Problem]]:
    """The column without the jumps of an angle that starts again after a turn, and a warning (SD531) if it has any.

    A turn is one of the column's unit, or of the joint behind its scale (counts of an encoder).
    """
    if channel.quantity is not Quantity.POSITION or not channel.unit.endswith(ANGLES):
        return column, []
    one = 2.0 * math.pi / channel.factor
    for turn in dict.fromkeys((one, one / abs(channel.scale))):
        steps = np.diff(column)
        jumps = np.abs(steps) > 0.5 * turn
        ordinary = float(np.max(np.abs(steps[~jumps]), initial=0.0))
        off = np.abs(np.abs(steps[jumps]) - turn)
        if 0 < np.count_nonzero(jumps) < len(steps) // 4 and float(off.max()) <= 2.0 * ordinary < 0.5 * turn:
            message = f"'{channel.column}' starts again after a turn {np.count_nonzero(jumps)} times"
            hint = "nothing: whole turns were added; or record an angle that goes on"
            return np.unwrap(column, period=turn), [Problem("SD531", message, where, hint)]
    return column, []
