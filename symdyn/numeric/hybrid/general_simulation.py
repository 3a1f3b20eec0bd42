"""Simulation of any machine: an explicit method of order 5 in each mode, with events located within its steps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, Problem
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.samples import samples
from symdyn.numeric.hybrid.signals import Piece, Signal
from symdyn.numeric.hybrid.trajectory import (
    DONE,
    EVENTS_AT_FIRST,
    MOST_EVENTS,
    ROOM,
    TOO_MANY,
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

FIRST_STEP = 1e-5  # s; the integrator finds its own from there
NEGLIGIBLE = 1e-3  # the absolute tolerance, as a share of the relative one, in SI units


def simulate_general(
    machine: Machine,
    time: Array,
    signals: Sequence[Signal],
    *,
    start: Array | None = None,
    tolerance: float = 1e-8,
) -> HybridTrajectory:
    """Integrate a machine and report at evenly spaced ``time`` (N,); ``signals`` one per input, ``start`` (nx,).

    The method of Dormand and Prince, order 5, with ``tolerance`` of each step relative to the state. Guards are
    watched through its interpolant of order 4, in the middle of every step and, unless they are far from zero there, at
    five points. What is sampled is reported as it is right after the sample.

    Raises InputError (SD302) for bad times, start, signals or tolerance, NumericalError (SD303) where switches chatter,
    steps become too short or the state leaves the finite numbers.
    """
    kernel, module = machine.kernel, machine.kernel.module
    nx, nu = len(kernel.states), len(kernel.inputs)
    x = np.zeros(nx) if start is None else np.array(start, dtype=np.float64)
    check(time, x, nx, signals, nu)
    if machine.p is not None:
        raise InputError(
            Problem("SD302", "this machine is not affine: put other parameters into its robot, and compile it")
        )
    if not 1e-13 <= tolerance <= 1e-2:
        raise InputError(Problem("SD302", f"a tolerance of {tolerance:g}: choose one from 1e-13 to 1e-2"))
    switches = np.zeros(len(machine.switches), np.int64)
    states = np.zeros((len(time), nx))
    states[0] = x
    found: list[Event] = []
    begun: list[Beginning] = []
    step, smallest = np.array([FIRST_STEP, 0.0]), np.full(nx, tolerance * NEGLIGIBLE)
    steps = tries = 0
    clocks = machine.clocks
    for first, last, dt in stretches(time, signals):
        powers, sines = _pieces([signal.piece_at(first) for signal in signals], first)
        u = np.zeros(nu)
        module._inputs(0.0, powers, sines, u)
        before = switches.copy()
        module.begin(x, u, switches)
        begun.append(Beginning(first, tuple(switches.tolist())))
        found += at_a_jump(before, switches, first, machine) if first > time[0] else []
        count = max(1, round((last - first) / dt))
        length = (last - first) / count
        times = np.linspace(0.0, last - first, count + 1)
        instants, which = samples(clocks, first, last, last == time[-1])
        every = np.zeros((count + 1, nx))
        events, tally = np.zeros((EVENTS_AT_FIRST, 4)), np.zeros(5, np.int64)
        step[1] = 0.0
        args = (x, switches, times, powers, sines, instants - first, which, step, tolerance, smallest, every)
        while (status := module.travel(*args, events, tally)) == ROOM:
            if len(events) >= MOST_EVENTS:
                status = TOO_MANY
                break
            events = np.concatenate([events, np.zeros_like(events)])
        found += [event(row, first, 1.0, machine) for row in events[: tally[0]]]
        if status != DONE:
            give_up(status, first + step[1], found, every, machine.kernel.states)
        steps, tries = steps + int(tally[1]), tries + int(tally[2])
        report_one(time, first, every[0], states)
        report(time, first, last, length, every, states)
    inputs = np.column_stack([signal.at(time) for signal in signals]) if nu else np.zeros((len(time), 0))
    return HybridTrajectory(np.asarray(time), states, inputs, tuple(found), tuple(begun), steps, tries)


def _pieces(pieces: Sequence[Piece], now: float) -> tuple[Array, Array]:
    """Powers (nu, P) and sines (nu, S, 3) of the inputs, in time since ``now``."""
    most = max((len(p.powers) for p in pieces), default=1)
    waves = max((len(p.sines) for p in pieces), default=0)
    powers, sines = np.zeros((len(pieces), most)), np.zeros((len(pieces), waves, 3))
    for k, piece in enumerate(pieces):
        shifted = piece.since(now)
        powers[k, : len(shifted.powers)] = shifted.powers
        for i, wave in enumerate(shifted.sines):
            sines[k, i] = wave
    return powers, sines
