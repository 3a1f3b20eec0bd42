"""Rows of the tables, and how they are measured."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Run = Callable[[], tuple[Array, int]]  # states and the number of events


@dataclass(frozen=True)
class Row:
    name: str
    error: float
    events: int
    speed: float  # simulated time over processor time


def measured(name: str, run: Run, reference: Array, end: float, repeats: int) -> Row:
    """The best of ``repeats`` after a first run, which compiles; without repeats, that one."""
    start = time.thread_time()
    states, events = run()
    spent = [thread_time(run) for _ in range(repeats)] or [time.thread_time() - start]
    return Row(name, error(states, reference), events, end / min(spent))


def thread_time(run: Callable[[], object]) -> float:
    start = time.thread_time()
    run()
    return time.thread_time() - start


def error(states: Array, reference: Array) -> float:
    """The largest of all states over all points, each over the largest size of its state."""
    return float((np.abs(states - reference).max(axis=0) / np.abs(reference).max(axis=0)).max())


def table(title: str, rows: Sequence[Row]) -> str:
    lines = [f"## {title}", "", "| | error | events | x real time |", "| --- | ---: | ---: | ---: |"]
    lines += [f"| {row.name} | {row.error:.1e} | {row.events} | {row.speed:.3g} |" for row in rows]
    return "\n".join([*lines, ""])
