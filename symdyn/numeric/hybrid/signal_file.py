"""An input from a table: a column over another one, with straight lines between the rows."""

from __future__ import annotations

import re
from pathlib import Path

from symdyn.base.errors import InputError, Problem, Where
from symdyn.base.units import UnitError, si_factor
from symdyn.numeric.hybrid.signals import Piece, Signal, sampled
from symdyn.numeric.recording_time import check_order
from symdyn.numeric.tables import read_table

_UNIT = re.compile(r"\[([^][]*)\]\s*$")


def read_signal(path: Path, unit: str, time: str, column: str) -> Signal:
    """The course of ``column`` over the column ``time``; held before the first row and behind the last.

    A unit in brackets at the end of a column's name counts; without one, numbers are in s and in ``unit``.

    Raises InputError: SD501 or SD502 where time runs backwards or stands still, SD504, SD505, SD510 and SD523 for what
    is no such table, SD508 for fewer than two rows, SD506 for a unit that is none or another's; with the place.
    """
    table = read_table(path, [time, column])

    def where(row: int) -> Where:
        return Where(str(path), int(table.lines[row]), table.positions[time])

    times = table.values[time] * _factor(path, time, "s")
    values = table.values[column] * _factor(path, column, unit)
    if len(times) < 2:
        raise InputError(Problem("SD508", "a course needs at least two rows", where(0)))
    problems = check_order(times, time, where, table.lines)
    if problems:
        raise InputError(problems)
    first = (Piece(0.0, (float(values[0]),)),) if times[0] > 0.0 else ()
    return Signal((*first, *sampled(times, values).pieces))


def _factor(path: Path, column: str, unit: str) -> float:
    found = _UNIT.search(column)
    if found is None:
        return 1.0
    try:
        return si_factor(found[1], unit)
    except UnitError as error:
        raise InputError(Problem("SD506", f"column '{column}': {error}", Where(str(path), 1))) from None
