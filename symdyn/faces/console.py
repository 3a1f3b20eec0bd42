"""What the command line prints: results on stdout, messages and progress on stderr."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from symdyn.base.errors import Problem, SymdynError
from symdyn.base.json_text import json_text

out = Console(highlight=False, soft_wrap=True)
err = Console(stderr=True, highlight=False, soft_wrap=True)


def print_json(facts: Any) -> None:
    """JSON for other programs: plain, no colour, no wrapping."""
    sys.stdout.write(json_text(facts))


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]], whole: str = "") -> None:
    """A table; the column named ``whole`` is not broken into lines where the others can be."""
    table = Table(title=title, title_justify="left", header_style="bold", show_edge=False, pad_edge=False)
    for column in columns:
        table.add_column(column, overflow="fold", no_wrap=column == whole)
    for row in rows:
        table.add_row(*row)
    out.print(table)


def print_error(error: SymdynError) -> None:
    for problem in error.problems:
        _print_problem(problem, "error", "bold red")


def print_warnings(problems: Iterable[Problem]) -> None:
    for problem in problems:
        _print_problem(problem, "warning", "yellow")


def _print_problem(problem: Problem, kind: str, style: str) -> None:
    err.print(kind, style=style, end=": ", markup=False)
    err.print(str(problem), markup=False)


class _Status:
    """Shows what is being done; a plain line per change where there is no terminal."""

    def __init__(self, progress: Progress | None, verbose: bool) -> None:
        self._progress, self._verbose = progress, verbose
        self._task = progress.add_task("", total=None) if progress else None

    def __call__(self, what: str) -> None:
        if self._progress is not None and self._task is not None:
            self._progress.update(self._task, description=what)
        elif self._verbose and not what.startswith("step "):
            err.print(what, markup=False)


@contextmanager
def status(quiet: bool = False) -> Iterator[_Status]:
    """A spinner with the current work on a terminal; else lines on stderr, none if ``quiet``."""
    if err.is_terminal and not quiet:
        columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
        with Progress(*columns, console=err, transient=True) as progress:
            yield _Status(progress, False)
    else:
        yield _Status(None, not quiet)
