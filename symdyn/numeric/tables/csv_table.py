"""CSV tables, plain or gzipped: comma-separated, decimal points, one header line, UTF-8."""

from __future__ import annotations

import csv
import difflib
import io
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from symdyn.base.errors import InputError, Problem, Where
from symdyn.numeric.tables.raw_table import RawTable
from symdyn.numeric.tables.text_file import failure, load_text

SUFFIXES = (".csv", ".csv.gz")
MAX_LISTED = 10  # problems of one kind that are listed one by one

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_DECIMAL_COMMA = re.compile(r"[0-9],[0-9]")
_SEPARATORS = {";": "';'", "\t": "a tab", "|": "'|'"}


def read_table(path: Path, columns: Sequence[str]) -> RawTable:
    """The named columns of a CSV file; other columns may hold anything.

    Raises InputError with every problem found: SD504 a cell that is no finite number, SD505 the
    file is no such table, SD510 a column is missing, SD522 the file is too big.
    """
    data, digest = load_text(path)
    try:
        header, positions = _header(path, data, columns)
        lines, ragged = _shape(path, data, width=len(header))
        if ragged:
            raise InputError([*ragged, *_bad_cells(path, data, positions, width=len(header))])
        if not lines.size:
            raise failure(path, "SD505", "the file has a header and no rows", line=2)
        values = _numbers(path, data, positions, lines, width=len(header))
    except csv.Error as error:
        raise failure(path, "SD505", f"the file is no CSV table: {error}") from error
    return RawTable(values, positions, lines, digest)


def _header(path: Path, data: bytes, columns: Sequence[str]) -> tuple[list[str], Mapping[str, int]]:
    """All names in the header, and the 1-based position of each wanted one."""
    line, fields = next(_records(data), (1, [""]))
    header = [field.strip() for field in fields]
    if len(header) == 1 and (separator := next((mark for mark in _SEPARATORS if mark in header[0]), None)):
        raise _wrong_separator(path, data, separator)
    if all(_NUMBER.fullmatch(name) for name in header):
        hint = "write the columns' names into the first line, separated by commas"
        raise failure(path, "SD505", "the first line holds numbers, where the columns' names belong", line, hint)
    problems = []
    positions = {}
    for name in dict.fromkeys(columns):
        found = [position for position, other in enumerate(header, 1) if other == name]
        if len(found) == 1:
            positions[name] = found[0]
        elif found:
            where = Where(str(path), line, found[1])
            problems.append(Problem("SD505", f"{len(found)} columns are named '{name}'", where, "rename all but one"))
        else:
            problems.append(Problem("SD510", f"no column '{name}'", Where(str(path), line), _near(name, header)))
    if problems:
        raise InputError(problems)
    return header, MappingProxyType(positions)


def _near(name: str, header: Sequence[str]) -> str:
    by_lower = {other.lower(): other for other in header}
    near = difflib.get_close_matches(name.lower(), by_lower, n=1)
    shown = ", ".join(header[:30]) + (f" and {len(header) - 30} more" if len(header) > 30 else "")
    return (f"did you mean '{by_lower[near[0]]}'? " if near else "") + f"columns there: {shown}"


def _wrong_separator(path: Path, data: bytes, separator: str) -> InputError:
    name = _SEPARATORS[separator]
    second = data.split(b"\n", 2)[1:2]
    decimal = bool(second and _DECIMAL_COMMA.search(second[0].decode()))
    message = f"fields are separated by {name}" + (" and numbers have decimal commas" if decimal else "")
    first = "first turn ',' into '.', then " if decimal else ""
    return failure(path, "SD505", message, 1, f"{first}turn {name} into ','")


def _shape(path: Path, data: bytes, width: int) -> tuple[NDArray[np.int64], list[Problem]]:
    """The line of each row, and a problem for each row that is not ``width`` fields wide."""
    if b'"' in data:
        counted = [(number, len(fields)) for number, fields in _records(data)]
    else:
        stream = io.BytesIO(data)
        counted = [(number, row.count(b",") + 1) for number, row in enumerate(stream, 1) if not row.isspace()]
    bad = [(number, count) for number, count in counted[1:] if count != width]
    problems = []
    for number, count in bad[:MAX_LISTED]:
        hint = "numbers with decimal commas? write decimal points" if count == 2 * width else ""
        message = f"{count} field{'s' if count > 1 else ''} where the header has {width}"
        problems.append(Problem("SD505", message, Where(str(path), number), hint))
    if len(bad) > MAX_LISTED:
        message = f"and {len(bad) - MAX_LISTED} more rows of another width than the header"
        problems.append(Problem("SD505", message, Where(str(path), bad[MAX_LISTED][0])))
    return np.array([number for number, _ in counted[1:]], dtype=np.int64), problems


def _numbers(
    path: Path, data: bytes, positions: Mapping[str, int], lines: NDArray[np.int64], width: int
) -> Mapping[str, NDArray[np.float64]]:
    """The wanted columns, by the fast path; the slow one is taken only to explain."""
    indices = sorted(position - 1 for position in positions.values())
    try:
        frame = pd.read_csv(
            io.BytesIO(data), header=None, index_col=False, names=range(width), usecols=indices,
            skiprows=int(lines[0]) - 1, dtype=np.dtype(np.float64), skipinitialspace=True,
        )  # fmt: skip
    except (ValueError, OverflowError):  # a cell that is no number; pandas does not say which
        unnamed = Problem("SD504", "a column holds text that is no number", Where(str(path)))
        raise InputError(_bad_cells(path, data, positions, width) or unnamed) from None
    if len(frame) != len(lines):
        raise failure(path, "SD505", "a quoted field runs over several lines", hint="write one row per line")
    values = {name: frame[position - 1].to_numpy(np.float64) for name, position in positions.items()}
    if any(map(_is_doubtful, values.values())) and (problems := _bad_cells(path, data, positions, width)):
        raise InputError(problems)
    return MappingProxyType(values)


def _is_doubtful(column: NDArray[np.float64]) -> bool:
    """Not finite, or all 0 and 1: pandas reads a column of True and False so."""
    return not np.isfinite(column).all() or bool(np.isin(column, (0.0, 1.0)).all())


def _bad_cells(path: Path, data: bytes, positions: Mapping[str, int], width: int) -> list[Problem]:
    """Every cell of the wanted columns, in rows of the right width, that is no finite number."""
    problems: list[Problem] = []
    bad_rows: set[int] = set()
    bad_count = row_count = 0
    records = _records(data)
    next(records)
    for line, fields in records:
        row_count += 1
        for name, position in positions.items():
            cell = fields[position - 1].strip() if len(fields) == width else "0"
            if _NUMBER.fullmatch(cell) and math.isfinite(float(cell)):
                continue
            bad_count += 1
            bad_rows.add(line)
            if bad_count <= MAX_LISTED:
                shown = f"'{cell[:30]}'" if cell else "an empty cell"
                message = f"column '{name}' holds {shown}, which is no finite number"
                problems.append(Problem("SD504", message, Where(str(path), line, position)))
    if problems:
        last = problems.pop()
        more = f"and {bad_count - MAX_LISTED} more cells; " if bad_count > MAX_LISTED else ""
        share = f"{len(bad_rows)} of {row_count} rows ({100 * len(bad_rows) / row_count:.3g} %) hold such cells"
        few = 2 * len(bad_rows) < row_count
        advice = "remove those rows, the recording is then split there" if few else "map a column of plain numbers"
        hint = f"{more}{share}; {advice}"
        problems.append(Problem(last.code, last.message, last.where, hint))
    return problems


def _records(data: bytes) -> Iterator[tuple[int, list[str]]]:
    """The line on which each record starts, and its fields; blank lines left out."""
    text = io.TextIOWrapper(io.BytesIO(data), encoding="utf-8", newline="")
    reader = csv.reader(text, skipinitialspace=True)
    start = 1
    for fields in reader:
        if len(fields) > 1 or any(field.strip() for field in fields):
            yield start, fields
        start = reader.line_num + 1
