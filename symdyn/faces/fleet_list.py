"""Reads a list of cases for a fleet: TOML with [[case]] tables, or CSV with the same words as columns."""

from __future__ import annotations

import csv
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from symdyn.base.errors import InputError, Problem, Where
from symdyn.spec.machines import machine_names

NEEDED = ("model", "recording")
KNOWN = ("name", *NEEDED, "holdout", "map")
SEVERAL = ("recording", "holdout")  # a text, or a list of them; in a CSV with semicolons between


@dataclass(frozen=True, slots=True)
class Case:
    """A model (a file, or a bundled machine's name) and its recordings, as absolute paths.

    Without any that are held out, blocks of the others judge.
    """

    name: str
    model: str
    recordings: tuple[str, ...]
    holdout: tuple[str, ...] = ()
    map: str | None = None


def read_cases(path: Path) -> list[Case]:
    """Cases in the order of the file; paths are relative to it.

    Raises InputError (SD341) with every line that is no case.
    """
    rows = _rows_of_toml(path) if path.suffix == ".toml" else _rows_of_csv(path)
    problems, cases = [], []
    for where, row in rows:
        wrong = [f"`{key}` is no word of a case" for key in row if key not in KNOWN]
        wrong += [f"`{key}` is missing" for key in NEEDED if not row.get(key)]
        wrong += [f"`{key}` must be a text" for key in row if not all(isinstance(v, str) for v in _listed(key, row))]
        if wrong:
            problems.append(Problem("SD341", "; ".join(wrong), where, f"known: {', '.join(KNOWN)}"))
            continue
        recordings, holdout = (tuple(_placed(path, text) for text in _listed(key, row)) for key in SEVERAL)
        channel_map = _placed(path, row["map"]) if row.get("map") else None
        name = row.get("name") or ", ".join(_listed("recording", row))
        cases.append(Case(name, _placed(path, row["model"]), recordings, holdout, channel_map))
    if not rows:
        problems.append(Problem("SD341", "the list holds no case", Where(str(path))))
    if problems:
        raise InputError(problems)
    return cases


def _listed(key: str, row: dict[str, Any]) -> list[Any]:
    """The texts of a word, of which some words may have several."""
    value = row.get(key, [])
    if isinstance(value, list) and key in SEVERAL:
        return value
    if isinstance(value, str) and key in SEVERAL:
        return [part.strip() for part in value.split(";")]
    return [value]


def _rows_of_toml(path: Path) -> list[tuple[Where, dict[str, Any]]]:
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(Problem("SD341", f"no TOML: {error}", Where(str(path)))) from None
    cases = document.get("case")
    if not isinstance(cases, list) or not all(isinstance(case, dict) for case in cases):
        hint = '[[case]] with model = "..", recording = "..", holdout = ".."'
        raise InputError(Problem("SD341", "a list of cases has [[case]] tables", Where(str(path)), hint))
    return [(Where(f"{path}, case {number}"), case) for number, case in enumerate(cases, 1)]


def _rows_of_csv(path: Path) -> list[tuple[Where, dict[str, Any]]]:
    try:
        with path.open(encoding="utf-8", newline="") as file:
            reader = csv.DictReader(file, restkey="more columns than the header")
            return [
                (Where(str(path), reader.line_num), {k: v for k, v in row.items() if v not in ("", None)})
                for row in reader
            ]
    except (csv.Error, UnicodeDecodeError) as error:
        raise InputError(Problem("SD341", f"no CSV: {error}", Where(str(path)))) from None


def _placed(path: Path, text: str) -> str:
    """A path of the list; the name of a bundled machine stays as it is."""
    return text if text in machine_names() else str((path.parent / text).resolve())
