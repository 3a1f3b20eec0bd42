"""What a simulation with located events gives, and what every way of computing it needs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Never

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, NumericalError, Problem
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.signals import Signal

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

CLOSE = 1e-9  # of times that are one, as a share of the reporting step
EVENTS_AT_FIRST, MOST_EVENTS = 4096, 10_000_000
DONE, NEED_BASE, NO_ROOM, CHATTERS, TOO_MANY, NOT_FINITE, TOO_SHORT, ROOM = range(8)  # how a stretch ended


@dataclass(frozen=True, slots=True)
class Event:
    """A switch that changed: for friction -1, 0 (sticks), 1; for contacts and limits 0 is in the gap, or inside."""

    time: float
    switch: str
    kind: str
    before: int
    after: int


@dataclass(frozen=True, slots=True)
class Beginning:
    """The state of every switch (S,) from ``time`` on: at the start, and where the course of an input changes.

    As in events, with +-2 for a contact that is beyond its clearance without pushing.
    """

    time: float
    switches: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class HybridTrajectory:
    """States (N, nx), inputs (N, nu) at ``time`` (N,), and all events between; ``steps`` were proven free of others.

    ``beginnings`` and events together tell the mode at any time.
    """

    time: Array
    states: Array
    inputs: Array
    events: tuple[Event, ...]
    beginnings: tuple[Beginning, ...]
    steps: int
    tries: int


def stretches(
    time: Array, signals: Sequence[Signal], instants: Sequence[float] = ()
) -> Iterator[tuple[float, float, float]]:
    """(first, last, step): between changes of the signals, ``instants``, and reporting times with another step."""
    t0, t1, dt = float(time[0]), float(time[-1]), float(time[1] - time[0])
    cuts = {p.start for signal in signals for p in signal.pieces if t0 < p.start < t1}
    cuts |= {t for t in instants if t0 < t < t1}
    edges = [t0, *sorted(cuts), t1]
    for a, b in pairwise(edges):
        low, high = t0 + dt * _ceil((a - t0) / dt), t0 + dt * _floor((b - t0) / dt)
        if high - low > 0.5 * dt:
            inner = [(a, low), (low, high), (high, b)]
        else:
            inner = [(a, b)] if low > high or low in (a, b) else [(a, low), (low, b)]
        for first, last in inner:
            if last - first > CLOSE * dt:
                yield first, last, dt


def _ceil(value: float) -> int:
    return int(np.ceil(value - CLOSE))


def _floor(value: float) -> int:
    return int(np.floor(value + CLOSE))


def report(time: Array, first: float, last: float, horizon: float, every: Array, states: Array) -> None:
    """Copy what was computed at the ends of steps to the reporting times among them."""
    dt = float(time[1] - time[0])
    low, high = _ceil((first - time[0]) / dt), _floor((last - time[0]) / dt)
    k = np.arange(max(low, 1), min(high, len(time) - 1) + 1)
    rows = np.rint((time[0] + k * dt - first) / horizon).astype(np.int64)
    states[k[rows > 0]] = every[rows[rows > 0]]


def report_one(time: Array, at: float, x: Array, states: Array) -> None:
    """Copy x to the reporting time ``at``, if it is one."""
    place = (at - time[0]) / (time[1] - time[0])
    if abs(place - round(place)) < CLOSE:
        states[round(place)] = x


def check(time: Array, x: Array, nx: int, signals: Sequence[Signal], nu: int) -> None:
    spacing = np.diff(time)
    if len(time) < 2 or not np.all(np.isfinite(time)) or spacing.min() <= 0 or np.ptp(spacing) > 1e-6 * spacing[0]:
        raise InputError(Problem("SD302", "times must be at least two, finite, increasing and evenly spaced"))
    if x.shape != (nx,) or not np.all(np.isfinite(x)):
        raise InputError(Problem("SD302", f"the start state needs {nx} finite numbers"))
    if len(signals) != nu:
        raise InputError(Problem("SD302", f"{nu} inputs need as many signals, not {len(signals)}"))


def event(row: Array, first: float, unit: float, machine: Machine) -> Event:
    """From a row of an integrator: time in units since ``first``, switch, state before and after."""
    k = int(row[1])
    module = machine.kernel.module
    return Event(first + float(row[0]) * unit, module.SWITCHES[k], module.SWITCH_KINDS[k], int(row[2]), int(row[3]))


def at_a_jump(before: Ints, after: Ints, time: float, machine: Machine) -> list[Event]:
    """What a jump of the inputs at ``time`` changes at once; ``before`` and ``after`` (switches,)."""
    rows = [np.array([0.0, k, before[k], after[k]]) for k in np.flatnonzero(before != after)]
    return [event(row, time, 1.0, machine) for row in rows]


def give_up(status: int, reached: float, found: Sequence[Event], rows: Array, names: Sequence[str]) -> Never:
    """Say where a run ended, by its status; ``rows`` (N, nx) are its last reports, of the states ``names``."""
    good = rows[np.isfinite(rows).all(axis=1) & rows.any(axis=1)]
    k = int(np.abs(good[-1]).argmax()) if len(good) else 0
    largest = f"; {names[k]} was {good[-1, k]:.3g} before" if len(good) else ""
    where = f"; it changed last at {found[-1].switch}" if found else ""
    what = {
        CHATTERS: f"the switches chatter at t = {reached:.9g} s{where}",
        TOO_MANY: f"more than {MOST_EVENTS} events by t = {reached:.6g} s{where}",
        NOT_FINITE: f"the state left the finite numbers at t = {reached:.6g} s{largest}",
        TOO_SHORT: f"steps became too short at t = {reached:.9g} s{where}",
    }
    raise NumericalError(
        Problem("SD303", what[status], hint="the model is unstable, or two of its laws contradict each other there")
    )
