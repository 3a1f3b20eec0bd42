"""Rows that show no motion of the machine: sensors that stood still while it moved, filters that had not settled."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import Problem
from symdyn.numeric.recording_time import PlaceOfRow, Samples, Segments
from symdyn.spec.records import Channel, Quantity

Mask = NDArray[np.bool_]
Measured = Sequence[tuple[Channel, Samples]]

BESIDE = 5  # samples on either side that a slope is taken over
STILL = 10  # equal rows, from which on they are looked at
STOPPED = 2.0  # times the largest change of slope anywhere else: with equal rows no force of that motion does this
SUDDEN = 5.0  # times that: no force does
LIVELY = 0.3  # of the samples at most are the same as the one before, where a channel has noise
END = 0.02  # of the rows: how late a filter settles
SETTLED = 3.0  # times as long as the change of slope is seen: the rest of an exponential is gone
MOVING = 0.5  # of a channel's range is passed without that end: the motion goes on
MOTION = (Quantity.POSITION, Quantity.VELOCITY)  # an effort may jump: a controller begins


def without_stills(measured: Measured, _: Segments, where: PlaceOfRow) -> tuple[Mask, list[Problem]]:
    """Rows (N,) that are samples, and a warning (SD535) where there are others.

    Those repeat all channels, noise included, and the machine moved before or after them as it can neither stop nor
    start.
    """
    count = len(measured[0][1])
    same = np.all([values[1:] == values[:-1] for _, values in measured], axis=0)
    starts = np.concatenate([[0], np.flatnonzero(~same) + 1])
    lengths = np.diff(np.append(starts, count))
    long = lengths >= STILL
    kept = np.ones(count, dtype=bool)
    if not np.any(long) or not any(_is_lively(channel, values, same) for channel, values in measured):
        return kept, []
    runs = list(zip(starts[long], starts[long] + lengths[long], strict=True))
    for channel, values in measured:
        if channel.quantity is Quantity.POSITION:
            bend = _bends(values)
            edges, near = np.zeros(count, dtype=bool), int(END * count)
            edges[:near] = edges[count - near :] = True  # filters settle there
            for start, stop in runs:
                for edge in (start, stop - 1):
                    edges[max(edge - BESIDE, 0) : edge + BESIDE + 1] = True
            limit = STOPPED * float(np.max(bend[~edges], initial=0.0))
            for start, stop in runs:
                if (start > 0 and bend[start] > limit) or (stop < count and bend[stop - 1] > limit):
                    kept[start + (start > 0) : stop] = False
    if np.all(kept):
        return kept, []
    first, lost = int(np.flatnonzero(~kept)[0]), int(np.count_nonzero(~kept))
    message = f"{lost} rows repeat every channel while the machine moved: nothing was read there"
    return kept, [Problem("SD535", message, where(first), "nothing: they were left out; or see why the logger stopped")]


def without_unsettled(measured: Measured, segments: Segments, where: PlaceOfRow) -> tuple[Mask, list[Problem]]:
    """Rows (N,) without those at either end, where a motion bends as nowhere else; a warning (SD536) for each end.

    Filters that start from zero, brakes that close. An end that holds most of the motion is
    the motion itself.
    """
    count = len(measured[0][1])
    kept, problems, near = np.ones(count, dtype=bool), [], max(int(END * count), 4 * BESIDE)
    if len(segments) > 1 or count < 4 * near:
        return kept, []
    for at_end in (False, True):
        cut, blamed = 0, ""
        for channel, values in measured:
            if channel.quantity not in MOTION:
                continue
            values = values[::-1] if at_end else values
            found = _unsettled(values, near)
            if found > cut:
                cut, blamed = found, channel.column
        if cut:
            rows = slice(count - cut, count) if at_end else slice(0, cut)
            kept[rows] = False
            end = "end" if at_end else "begin"
            message = f"the {end}{'' if at_end else 'ning'} of '{blamed}' bends as it does nowhere else"
            hint = f"nothing: {cut} rows were left out; or record after filters have settled and brakes are open"
            problems.append(Problem("SD536", message, where(rows.start), hint))
    return kept, problems


def _unsettled(values: Samples, near: int) -> int:
    """How many samples at the beginning to leave out."""
    inner, bend = values[near:-near], _bends(values)
    usual = float(bend[near + BESIDE : -near - BESIDE].max())
    if np.ptp(inner) < MOVING * np.ptp(values) or usual == 0.0 or bend[: near + 1].max() <= SUDDEN * usual:
        return 0
    last = int(np.flatnonzero(bend[: near + 1] > usual)[-1])
    return int(SETTLED * (last + BESIDE))


def _bends(values: Samples) -> Samples:
    """(N,) by how much the slope after a sample differs from that before, per sample; at the ends zero."""
    bend = np.zeros(len(values))
    inner = values[BESIDE:-BESIDE]
    bend[BESIDE:-BESIDE] = np.abs(values[2 * BESIDE :] + values[: -2 * BESIDE] - 2.0 * inner) / BESIDE
    return bend


def _is_lively(channel: Channel, values: Samples, same: Mask) -> bool:
    """Whether the channel has noise that changes from sample to sample, where not every channel stands."""
    changes = values[1:] != values[:-1]
    return channel.quantity is not Quantity.POSITION and float(np.mean(changes[~same])) >= 1.0 - LIVELY
