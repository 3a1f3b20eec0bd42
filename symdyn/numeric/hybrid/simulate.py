"""Simulation with located events: from a machine, signals and a start to a trajectory and its events."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, NumericalError, Problem
from symdyn.numeric.hybrid import affine
from symdyn.numeric.hybrid.affine_modes import Modes, room
from symdyn.numeric.hybrid.exponential import growth_rate
from symdyn.numeric.hybrid.machine import FRICTION, Machine
from symdyn.numeric.hybrid.signals import Signal, constant, exosystem

Array = NDArray[np.float64]

LEVELS = 27  # halvings of a step down to the length to which events are located: 7e-9 of a step
MODES_AT_FIRST, EVENTS_AT_FIRST = 32, 4096
MOST_EVENTS = 10_000_000
LONGEST = 32.0  # of a step, over the machine's fastest time


@dataclass(frozen=True, slots=True)
class Event:
    """A switch that changed: for friction -1, 0 (sticks), 1; for contacts and limits 0 is in the gap, or inside."""

    time: float
    switch: str
    kind: str
    before: int
    after: int


@dataclass(frozen=True, slots=True)
class HybridTrajectory:
    """States (N, nx), inputs (N, nu) at ``time`` (N,), and all events between; ``steps`` were proven free of others."""

    time: Array
    states: Array
    inputs: Array
    events: tuple[Event, ...]
    steps: int
    tries: int


def simulate_affine(
    machine: Machine, time: Array, signals: Sequence[Signal], *, start: Array | None = None
) -> HybridTrajectory:
    """Propagate a machine that is affine in every mode, exactly, and report at evenly spaced ``time`` (N,).

    ``signals`` one per input; ``start`` (nx,) defaults to rest at the origin. Each mode is a linear system,
    whose exponential is applied; a step counts only when its guards have been proven positive all along
    it, so that no event is missed. Events are located to 7e-9 of a reporting step.

    Raises InputError (SD302) for bad times, start or signals, NumericalError (SD303) where the switches chatter or
    the state leaves the finite numbers, with the place and the time.
    """
    kernel = machine.kernel
    nx, nu = len(kernel.states), len(kernel.inputs)
    x = np.zeros(nx) if start is None else np.array(start, dtype=np.float64)
    _check(time, x, nx, signals, nu)
    switches = len(machine.switches)
    state = np.zeros(switches, np.int64)
    states = np.zeros((len(time), nx))
    states[0] = x
    found: list[Event] = []
    steps = tries = 0
    for first, last, step in _stretches(time, signals):
        pieces = [signal.piece_at(first) for signal in signals]
        system, output, w = exosystem(pieces, first)
        bases, known = machine.bases(system, output)
        n = bases.a.shape[1]
        z = np.zeros(n)
        z[:nx], z[nx : nx + len(w)], z[-1] = x, w, 1.0
        longest = LONGEST / max(growth_rate(a) for a in bases.a)
        count = max(1, round((last - first) / step)) * max(1, int(np.ceil(step / longest)))
        horizon = (last - first) / count
        every = np.zeros((count + 1, n))
        events = np.zeros((EVENTS_AT_FIRST, 4))
        tally = np.zeros(5, np.int64)
        modes = room(MODES_AT_FIRST, LEVELS, n, machine.count(FRICTION), machine.most_guards)
        affine.begin(z, state, bases, known)
        while True:
            status = affine.propagate(z, state, bases, known, modes, horizon, int(tally[3]), count, every, events, tally)
            if status == affine.NO_ROOM:
                modes = _roomier(modes)
            elif status == affine.TOO_MANY and len(events) < MOST_EVENTS:
                events = np.concatenate([events, np.zeros_like(events)])
            else:
                break
        reached = first + (tally[3] + tally[4] * 0.5 ** (LEVELS - 1)) * horizon
        found += [_event(row, first, horizon, machine) for row in events[: tally[0]]]
        if status != affine.DONE:
            _give_up(status, reached, found)
        steps, tries = steps + int(tally[1]), tries + int(tally[2])
        _report(time, first, last, horizon, every[:, :nx], states)
        x = z[:nx].copy()
    inputs = np.column_stack([signal.at(time) for signal in signals]) if nu else np.zeros((len(time), 0))
    return HybridTrajectory(np.asarray(time), states, inputs, tuple(found), steps, tries)


def _stretches(time: Array, signals: Sequence[Signal]) -> Iterator[tuple[float, float, float]]:
    """(first, last, step): between changes of the signals, and never across a reporting time with another step."""
    t0, t1, dt = float(time[0]), float(time[-1]), float(time[1] - time[0])
    cuts = {p.start for signal in signals for p in signal.pieces if t0 < p.start < t1}
    edges = [t0, *sorted(cuts), t1]
    for a, b in pairwise(edges):
        low, high = t0 + dt * _ceil((a - t0) / dt), t0 + dt * _floor((b - t0) / dt)
        if high - low > 0.5 * dt:
            inner = [(a, low), (low, high), (high, b)]
        else:
            inner = [(a, b)] if low > high or low in (a, b) else [(a, low), (low, b)]
        for first, last in inner:
            if last - first > 1e-9 * dt:
                yield first, last, dt


def _ceil(value: float) -> int:
    return int(np.ceil(value - 1e-9))


def _floor(value: float) -> int:
    return int(np.floor(value + 1e-9))


def _report(time: Array, first: float, last: float, horizon: float, every: Array, states: Array) -> None:
    """Copy what was computed at the ends of steps to the reporting times among them."""
    dt = float(time[1] - time[0])
    low, high = _ceil((first - time[0]) / dt), _floor((last - time[0]) / dt)
    for k in range(max(low, 1), min(high, len(time) - 1) + 1):
        row = round((time[0] + k * dt - first) / horizon)
        if row > 0:
            states[k] = every[row]


def _check(time: Array, x: Array, nx: int, signals: Sequence[Signal], nu: int) -> None:
    spacing = np.diff(time)
    if len(time) < 2 or not np.all(np.isfinite(time)) or spacing.min() <= 0 or np.ptp(spacing) > 1e-6 * spacing[0]:
        raise InputError(Problem("SD302", "times must be at least two, finite, increasing and evenly spaced"))
    if x.shape != (nx,) or not np.all(np.isfinite(x)):
        raise InputError(Problem("SD302", f"the start state needs {nx} finite numbers"))
    if len(signals) != nu:
        raise InputError(Problem("SD302", f"{nu} inputs need as many signals, not {len(signals)}"))


def _roomier(modes: Modes) -> Modes:
    """Twice the storage, with the modes that are made already."""
    grown = [np.concatenate([part, np.full_like(part, -1 if k == 1 else 0)]) if k else part for k, part in enumerate(modes)]
    return Modes(*grown)


def _event(row: Array, first: float, horizon: float, machine: Machine) -> Event:
    k = int(row[1])
    module = machine.kernel.module
    return Event(first + float(row[0]) * horizon, module.SWITCHES[k], module.SWITCH_KINDS[k], int(row[2]), int(row[3]))


def _give_up(status: int, reached: float, found: Sequence[Event]) -> None:
    where = f"; it changed last at {found[-1].switch}" if found else ""
    what = {
        affine.CHATTERS: f"the switches chatter at t = {reached:.9g} s{where}",
        affine.TOO_MANY: f"more than {MOST_EVENTS} events by t = {reached:.6g} s{where}",
        affine.NOT_FINITE: f"the state left the finite numbers at t = {reached:.6g} s",
    }
    raise NumericalError(
        Problem("SD303", what[status], hint="the model is unstable, or two of its laws contradict each other there")
    )
