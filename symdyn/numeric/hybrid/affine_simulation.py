"""Simulation of machines that are affine in every mode: exact between events."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid import affine
from symdyn.numeric.hybrid.affine_modes import Modes, room
from symdyn.numeric.hybrid.exponential import growth_rate
from symdyn.numeric.hybrid.machine import FRICTION, Machine
from symdyn.numeric.hybrid.samples import changes, due_at, samples, updated
from symdyn.numeric.hybrid.signals import Signal, exosystem
from symdyn.numeric.hybrid.trajectory import (
    CLOSE,
    DONE,
    EVENTS_AT_FIRST,
    MOST_EVENTS,
    NO_ROOM,
    TOO_MANY,
    Event,
    HybridTrajectory,
    check,
    event,
    give_up,
    report,
    report_one,
    stretches,
)

Array = NDArray[np.float64]

LOCATED = 1e-11  # s, to which events are located
FEWEST, MOST = 20, 45  # halvings of a step down to that
MODES_AT_FIRST = 32
LONGEST = 32.0  # of a step, over the machine's fastest time


def simulate_affine(
    machine: Machine, time: Array, signals: Sequence[Signal], *, start: Array | None = None
) -> HybridTrajectory:
    """Propagate a machine that is affine in every mode, exactly, and report at evenly spaced ``time`` (N,).

    ``signals`` one per input; ``start`` (nx,) defaults to rest at the origin. Each mode is a linear system,
    whose exponential is applied; a step counts only when its guards have been proven positive all along
    it, so that no event is missed. Events are located to 1e-11 s. What is sampled is reported as it is right
    after the sample.

    Raises InputError (SD302) for bad times, start or signals, NumericalError (SD303) where the switches chatter or
    the state leaves the finite numbers, with the place and the time.
    """
    kernel = machine.kernel
    nx, nu = machine.size, len(kernel.inputs)
    x = np.zeros(nx) if start is None else np.array(start, dtype=np.float64)
    check(time, x, nx, signals, nu)
    switches = len(machine.switches)
    state = np.zeros(switches, np.int64)
    states = np.zeros((len(time), nx))
    states[0] = x
    found: list[Event] = []
    steps = tries = 0
    instants = samples(machine.clocks, float(time[0]), float(time[-1]), closed=True)
    close = CLOSE * float(time[1] - time[0])
    for first, last, step in stretches(time, signals, instants[0].tolist()):
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
        levels = min(MOST, max(FEWEST, 1 + math.ceil(math.log2(horizon / LOCATED))))
        modes = room(MODES_AT_FIRST, levels, n, machine.count(FRICTION), machine.most_guards)
        affine.begin(z, state, bases, known)
        due = due_at(instants, first, close)
        if len(due):
            before = state.copy()
            z[:nx] = updated(machine, x, signals, first, due)
            affine.begin(z, state, bases, known)
            found += changes(machine, before, state, first)
            report_one(time, first, z[:nx], states)
        while True:
            status = affine.propagate(
                z, state, bases, known, modes, horizon, int(tally[3]), count, every, events, tally
            )
            if status == NO_ROOM:
                modes = _roomier(modes)
            elif status == TOO_MANY and len(events) < MOST_EVENTS:
                events = np.concatenate([events, np.zeros_like(events)])
            else:
                break
        reached = first + (tally[3] + tally[4] * 0.5 ** (levels - 1)) * horizon
        found += [event(row, first, horizon, machine) for row in events[: tally[0]]]
        if status != DONE:
            give_up(status, reached, found)
        steps, tries = steps + int(tally[1]), tries + int(tally[2])
        report(time, first, last, horizon, every[:, :nx], states)
        x = z[:nx].copy()
    states[-1] = updated(machine, x, signals, float(time[-1]), due_at(instants, float(time[-1]), close))
    inputs = np.column_stack([signal.at(time) for signal in signals]) if nu else np.zeros((len(time), 0))
    return HybridTrajectory(np.asarray(time), states, inputs, tuple(found), steps, tries)


def _roomier(modes: Modes) -> Modes:
    """Twice the storage, with the modes that are made already."""
    made, size = len(modes.codes), modes.bounds.shape
    grown = room(2 * made, modes.step.shape[1], size[1], modes.sigma.shape[1], size[2])
    grown.made[:] = modes.made
    for new, old in zip(grown[1:], modes[1:], strict=True):
        new[:made] = old
    return grown
