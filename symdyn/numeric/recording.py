"""A recording of a machine in SI units, read through a channel map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import BadRecording, InputError, Problem, Where
from symdyn.numeric.recording_checks import check_channels
from symdyn.numeric.recording_quality import check_sensors, quantisation_noise
from symdyn.numeric.recording_repeats import check_repeats, fresh_rows, unwrapped
from symdyn.numeric.recording_rows import without_stills, without_unsettled
from symdyn.numeric.recording_spikes import without_spikes
from symdyn.numeric.recording_time import check_time, split_at_gaps
from symdyn.numeric.tables import read_table
from symdyn.numeric.tables.raw_table import RawTable
from symdyn.spec.records import Channel, ChannelMap, Quantity, Side

ChannelKey = tuple[Quantity, str, Side]
UNREADABLE = frozenset({"SD504", "SD505"})  # of a file that is there, but holds no table of finite numbers


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """What was measured, in SI units with signs and scales applied; arrays are read-only.

    ``time`` is (N,), strictly increasing, in s; each channel is (N,). ``segments`` are the
    stretches without gaps, as slices into both; ``sample_time`` is the median step.
    """

    name: str
    time: NDArray[np.float64]
    channels: Mapping[ChannelKey, NDArray[np.float64]]
    sample_time: float
    segments: tuple[slice, ...]
    warnings: tuple[Problem, ...]
    sha256: str

    @property
    def quantisation(self) -> Mapping[ChannelKey, float]:
        """Noise of rounding of each channel, a standard deviation in SI units; 0 where it has no steps."""
        return {key: quantisation_noise(values) for key, values in self.channels.items()}

    def has(self, quantity: Quantity, joint: str, side: Side | None = None) -> bool:
        """Whether the quantity was measured at the joint (``side`` None: at either side)."""
        return self.key(quantity, joint, side) is not None

    def channel(self, quantity: Quantity, joint: str, side: Side | None = None) -> NDArray[np.float64]:
        """The (N,) samples of a quantity; with ``side`` None the link's before the motor's.

        Raises InputError (SD510) when it was not measured.
        """
        key = self.key(quantity, joint, side)
        if key is None:
            at = f" at the {side} side" if side else ""
            there = "; ".join(f"{q} of {j} ({s})" for q, j, s in self.channels)
            message = f"recording '{self.name}' has no {quantity} of '{joint}'{at}"
            raise InputError(Problem("SD510", message, hint=f"measured there: {there}"))
        return self.channels[key]

    def key(self, quantity: Quantity, joint: str, side: Side | None = None) -> ChannelKey | None:
        """Which channel shows the quantity; with ``side`` None the link's before the motor's. None where none does."""
        sides = (side,) if side else (Side.LINK, Side.MOTOR)
        return next((key for s in sides if (key := (quantity, joint, s)) in self.channels), None)


def read_recording(path: Path | str, channel_map: ChannelMap) -> Recording:
    """Read and check a recording.

    Raises BadRecording with every problem found in the numbers, each with the file, its line and its
    column (codes SD501 to SD536), and InputError where the file or a column is not there. What is only
    suspect stands in ``Recording.warnings``.
    """
    path = Path(path)
    _refuse_duplicates(channel_map)
    table = _table(path, (channel_map.time_column, *(channel.column for channel in channel_map.channels)))
    time_column = table.positions[channel_map.time_column]
    rows, written = fresh_rows([table.values[channel.column] for channel in channel_map.channels])
    time, lines = (table.values[channel_map.time_column] * channel_map.time_factor)[rows], table.lines[rows]

    def where(row: int | None = None, column: int | None = None) -> Where:
        return Where(str(path), int(lines[row]) if row is not None else None, column)

    problems = check_time(time, channel_map.time_column, lambda row: where(row, time_column), lines)
    if problems:
        raise BadRecording(problems)
    segments, _, _ = split_at_gaps(time, where)
    places = {channel: Where(str(path), 1, table.positions[channel.column]) for channel in channel_map.channels}
    measured, doubts = [], check_repeats(written, where(0, time_column))
    known = [(c, _to_si(table.values[c.column][rows], c)) for c in channel_map.channels if _is_known(c)]
    for channel in (c for c in channel_map.channels if not _is_known(c)):
        column, turns = unwrapped(channel, table.values[channel.column][rows], places[channel])
        column, spikes = without_spikes(channel, column, segments, places[channel])
        measured.append((channel, _to_si(column, channel)))
        doubts += (*turns, *spikes)
    left_out: list[Problem] = []
    for shows_motion in (without_stills, without_unsettled):
        kept, told = shows_motion(measured, split_at_gaps(time, where)[0], where)
        time, lines = time[kept], lines[kept]
        measured, known = ([(channel, values[kept]) for channel, values in each] for each in (measured, known))
        left_out += told
        problems = check_time(time, channel_map.time_column, lambda row: where(row, time_column), lines)
        if problems:
            raise BadRecording((*left_out, *problems))
    segments, gap_errors, gap_warnings = split_at_gaps(time, lambda row: where(row, time_column))
    errors, warnings = check_channels(time, segments, measured, places)
    worse, more = check_sensors(time, segments, measured, places)
    if gap_errors or errors or worse:
        raise BadRecording((*gap_errors, *errors, *worse))
    return Recording(
        name=path.name.removesuffix(".gz").rpartition(".")[0],
        time=frozen(time),
        channels=MappingProxyType({_key(channel): frozen(values) for channel, values in (*measured, *known)}),
        sample_time=float(np.median(np.diff(time))),
        segments=segments,
        warnings=(*gap_warnings, *doubts, *left_out, *warnings, *more),
        sha256=table.sha256,
    )


def frozen(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The samples of a channel, read-only."""
    values.setflags(write=False)
    return values


def _table(path: Path, columns: Sequence[str]) -> RawTable:
    try:
        return read_table(path, columns)
    except InputError as error:
        if any(problem.code in UNREADABLE for problem in error.problems):
            raise BadRecording(error.problems) from error
        raise


def _key(channel: Channel) -> ChannelKey:
    return channel.quantity, channel.joint, channel.side


def _refuse_duplicates(channel_map: ChannelMap) -> None:
    first: dict[ChannelKey, Channel] = {}
    problems = []
    for channel in channel_map.channels:
        other = first.setdefault(_key(channel), channel)
        if other is not channel:
            what = f"{channel.quantity} of '{channel.joint}' at the {channel.side} side"
            message = f"columns '{other.column}' and '{channel.column}' both claim the {what}"
            problems.append(Problem("SD511", message, channel.where, "remove one of the two"))
    if problems:
        raise InputError(problems)


def _is_known(channel: Channel) -> bool:
    return channel.quantity is Quantity.PARAMETER


def _to_si(column: NDArray[np.float64], channel: Channel) -> NDArray[np.float64]:
    return column * (channel.sign * channel.scale * channel.factor)
