"""Simulation of machines that are affine in every mode: exact between events."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid import affine
from symdyn.numeric.hybrid.affine_modes import Modes
from symdyn.numeric.hybrid.affine_store import MOST_STEPS, Bases, divided, levels_of, roomier
from symdyn.numeric.hybrid.affine_switches import BASE, EVENTS, STEP, STEPS, TALLY, TICK, TRIES, begin, pick
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.samples import due_at, samples, updated
from symdyn.numeric.hybrid.signals import Signal, exosystem
from symdyn.numeric.hybrid.trajectory import (
    CLOSE,
    DONE,
    EVENTS_AT_FIRST,
    MOST_EVENTS,
    NEED_BASE,
    NO_ROOM,
    TOO_MANY,
    TOO_SHORT,
    Beginning,
    Event,
    HybridTrajectory,
    at_a_jump,
    check,
    event,
    give_up,
    report,
    report_one,
    stretches,
)

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

MODES_AT_FIRST = 32


@dataclass
class _Prepared:
    """Modes of one machine with inputs of one kind, for steps of one length."""

    bases: Bases
    modes: Modes
    horizon: float
    stride: int  # steps between reports


class Affine:
    """A machine that is affine in every mode, with all modes that its simulations have met so far.

    Each further simulation with inputs of the same kind and the same spacing of times needs no more set-up.
    """

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self._prepared: dict[tuple[bytes, bytes, float], _Prepared] = {}

    def simulate(self, time: Array, signals: Sequence[Signal], *, start: Array | None = None) -> HybridTrajectory:
        """See ``simulate_affine``."""
        machine = self.machine
        nx, nu = machine.size, len(machine.kernel.inputs)
        x = np.zeros(nx) if start is None else np.array(start, dtype=np.float64)
        check(time, x, nx, signals, nu)
        state = np.zeros(len(machine.switches), np.int64)
        states = np.zeros((len(time), nx))
        states[0] = x
        found: list[Event] = []
        begun: list[Beginning] = []
        steps = tries = 0
        instants = samples(machine.clocks, float(time[0]), float(time[-1]), closed=True)
        close = CLOSE * float(time[1] - time[0])
        for first, last, step in stretches(time, signals, instants[0].tolist()):
            due = due_at(instants, first, close)
            if len(due):
                x = updated(machine, x, signals, first, due)
                report_one(time, first, x, states)
            system, output, w = exosystem([signal.piece_at(first) for signal in signals], first)
            count, length = divided(first, last, step)
            prepared = self._prepare(system, output, length)
            z = np.zeros(machine.width(len(w)))
            z[:nx], z[nx : nx + len(w)], z[nx + len(w)] = x, w, 1.0
            tally = np.zeros(len(TALLY), np.int64)
            reports = np.zeros((count + 1, nx))
            before = state.copy()
            status, events, switches = _run(prepared, z, state, count, reports, tally)
            begun.append(Beginning(first, switches))
            found += at_a_jump(before, np.array(switches), first, machine) if first > time[0] else []
            horizon, ticks = prepared.horizon, 1 << (prepared.modes.step.shape[1] - 1)
            found += [event(row, first, horizon, machine) for row in events[: tally[EVENTS]]]
            if status != DONE:
                reached = first + (tally[STEP] + tally[TICK] / ticks) * horizon
                give_up(status, reached, found, reports, machine.kernel.states)
            steps, tries = steps + int(tally[STEPS]), tries + int(tally[TRIES])
            report(time, first, last, length, reports, states)
            x = z[:nx].copy()
        states[-1] = updated(machine, x, signals, float(time[-1]), due_at(instants, float(time[-1]), close))
        inputs = np.column_stack([signal.at(time) for signal in signals]) if nu else np.zeros((len(time), 0))
        return HybridTrajectory(np.asarray(time), states, inputs, tuple(found), tuple(begun), steps, tries)

    def _prepare(self, system: Array, output: Array, length: float) -> _Prepared:
        key = (system.tobytes(), output.tobytes(), length)
        if key not in self._prepared:
            bases = Bases.make(self.machine, system[None], output[None], self.machine.parameters[None])
            stride = int(bases.steps(length)[0])
            modes = bases.room(MODES_AT_FIRST, levels_of(length / stride))
            self._prepared[key] = _Prepared(bases, modes, length / stride, stride)
        return self._prepared[key]


def _run(
    prepared: _Prepared, z: Array, state: Ints, count: int, reports: Array, tally: Ints
) -> tuple[int, Array, tuple[int, ...]]:
    """Propagate to the end, making room and bases as they are needed; also the switches at the beginning."""
    switches = tuple(state.tolist())
    if prepared.stride > MOST_STEPS:
        return TOO_SHORT, np.zeros((0, 4)), switches
    events, begun = np.zeros((EVENTS_AT_FIRST, 4)), False
    while True:
        bases, known = pick(prepared.bases.stacked, 0), prepared.bases.known
        if not begun:
            status = begin(z, state, bases, known, tally)
            begun, switches = status == DONE, tuple(state.tolist())
        if begun:
            status = affine.propagate(
                z, state, bases, known, prepared.modes, prepared.horizon, count * prepared.stride, prepared.stride,
                reports, events, tally,
            )  # fmt: skip
        if status == NEED_BASE:
            prepared.bases.add(int(tally[BASE]))
        elif status == NO_ROOM:
            prepared.modes = roomier(prepared.modes)
        elif status == TOO_MANY and len(events) < MOST_EVENTS:
            events = np.concatenate([events, np.zeros_like(events)])
        else:
            return status, events, switches


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
    return Affine(machine).simulate(time, signals, start=start)
