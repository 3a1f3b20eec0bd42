"""Thousands of simulations of one machine in one call: sets of parameters, starts or inputs, on all cores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numba import get_num_threads, njit, prange
from numpy.typing import NDArray

from symdyn.base.errors import InputError, Problem
from symdyn.numeric.hybrid.affine import propagate
from symdyn.numeric.hybrid.affine_modes import Base, room
from symdyn.numeric.hybrid.affine_store import MOST_STEPS, Bases, divided, levels_of
from symdyn.numeric.hybrid.affine_switches import BASE, EVENTS, STEPS, TALLY, begin, pick
from symdyn.numeric.hybrid.batch_singly import Found, simulate_singly
from symdyn.numeric.hybrid.machine import FRICTION, Machine
from symdyn.numeric.hybrid.signals import Signal, exosystem
from symdyn.numeric.hybrid.trajectory import (
    CHATTERS,
    DONE,
    NEED_BASE,
    NO_ROOM,
    NOT_FINITE,
    TOO_SHORT,
    check,
    report,
    stretches,
)

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

CHUNK = 256  # sets that are prepared and simulated together
MODES_AT_FIRST = 32
BEGINS = 100  # a status before the first step of a stretch
ENDED = {
    DONE: "",
    CHATTERS: "the switches chatter",
    NOT_FINITE: "the state left the finite numbers",
    TOO_SHORT: "steps became too short",
}


@dataclass(frozen=True, slots=True)
class Batch:
    """B simulations. What ended early has a ``failure`` that says so, and is not a number from there on.

    Of machines that are not propagated together, it is not a number at all.
    """

    time: Array  # (N,)
    states: Array  # (B, N, nx)
    events: Ints  # (B,) how many
    steps: Ints  # (B,) proven free of others
    failures: tuple[str, ...]  # (B,), empty where all is well


def simulate_batch(
    machine: Machine,
    time: Array,
    signals: Sequence[Signal] | Sequence[Sequence[Signal]],
    *,
    parameters: Array | None = None,
    starts: Array | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Batch:
    """Simulate B sets, each as ``simulate_events`` does it alone, bit by bit, on all threads of Numba.

    ``signals`` one per input, for all, or B lists of them whose pieces begin at the same times and have the same
    shapes. ``parameters`` (B, np) and ``starts`` (B, nx); what is not given is as in the machine, and at rest.
    ``progress`` is told how many of how many sets are done. Machines that are affine in every mode, and not sampled,
    are propagated together, in compiled code; others one by one.

    Raises InputError (SD302) for what no set can be simulated with, or for ``parameters`` of a machine that is not
    affine, whose code holds its numbers. A set that fails says so in ``failures``, and the others go on.
    """
    kernel = machine.kernel
    nx, nu = len(kernel.states), len(kernel.inputs)
    each = _lists(signals)
    given = {len(part) for part in (parameters, starts, each if len(each) > 1 else None) if part is not None}
    if len(given) > 1:
        raise InputError(Problem("SD302", "sets of different numbers were given"))
    if parameters is not None and not machine.affine:
        hint = "put each set of parameters into the robot, and compile it"
        raise InputError(Problem("SD302", "this machine is not affine: its code holds its numbers", hint=hint))
    sets = given.pop() if given else 1
    p = np.broadcast_to(machine.parameters, (sets, len(kernel.parameters))) if parameters is None else parameters
    x = np.zeros((sets, nx)) if starts is None else np.array(starts, dtype=np.float64)
    if p.shape != (sets, len(kernel.parameters)) or x.shape != (sets, nx):
        raise InputError(Problem("SD302", f"{len(kernel.parameters)} parameters and {nx} states are needed for a set"))
    for one in each:
        check(time, np.zeros(nx), nx, one, nu)
    if not machine.affine or len(machine.clocks):
        return _singly(time, simulate_singly(machine, time, each, parameters, x, progress), x)
    if len({tuple(stretches(time, one)) for one in each}) > 1:
        raise InputError(Problem("SD302", "inputs of all sets must change at the same times"))
    counts = np.zeros((2, sets), np.int64)
    batch = Batch(time, np.full((sets, len(time), nx), np.nan), counts[0], counts[1], ())
    status = np.zeros(sets, np.int64)
    met: set[int] = set()
    for first in range(0, sets, CHUNK):
        here = slice(first, min(first + CHUNK, sets))
        inputs = each if len(each) == 1 else each[here]
        status[here] = _chunk(machine, inputs, p[here], x[here], batch, here, met)
        if progress is not None:
            progress(here.stop, sets)
    return Batch(time, batch.states, batch.events, batch.steps, tuple(ENDED[int(s)] for s in status))


def _singly(time: Array, found: Sequence[Found], starts: Array) -> Batch:
    states = np.full((len(found), len(time), starts.shape[1]), np.nan)
    events, steps = np.zeros((2, len(found)), np.int64)
    failures = [""] * len(found)
    for k, one in enumerate(found):
        if isinstance(one, str):
            failures[k] = one
        else:
            states[k], events[k], steps[k] = one.states, len(one.events), one.steps
    return Batch(time, states, events, steps, tuple(failures))


def _lists(signals: Sequence[Signal] | Sequence[Sequence[Signal]]) -> list[list[Signal]]:
    """One list for all, or one for each."""
    common = [signal for signal in signals if isinstance(signal, Signal)]
    return [common] if len(common) == len(signals) else [list(s) for s in signals if not isinstance(s, Signal)]


def _chunk(
    machine: Machine, each: list[list[Signal]], p: Array, x: Array, batch: Batch, here: slice, met: set[int]
) -> Ints:
    """Simulate some sets from ``x``, which is overwritten, into their place in the batch; how each ended.

    ``met`` are combinations of contacts and limits that sets have met so far: sets that stop for one start anew.
    """
    sets, nx = x.shape
    states, time = batch.states[here], batch.time
    states[:, 0] = x
    switches = np.zeros((sets, len(machine.switches)), np.int64)
    good = np.all(np.isfinite(p), axis=1) & np.all(np.isfinite(x), axis=1)
    ended = np.where(good, DONE, NOT_FINITE)
    for first, last, step in stretches(time, each[0]):
        going = np.flatnonzero(ended == DONE)
        if not len(going):
            break
        made = [exosystem([signal.piece_at(first) for signal in signals], first) for signals in each]
        if len({system.shape for system, _, _ in made}) > 1:
            raise InputError(Problem("SD302", "inputs of all sets must have the same shapes"))
        systems, outputs, w = (
            np.array(np.broadcast_to(part, (sets, *part.shape[1:])))[going]
            for part in (np.stack(parts) for parts in zip(*made, strict=True))
        )
        bases = Bases.make(machine, systems, outputs, p[going], tuple(sorted(met)))
        count, length = divided(first, last, step)
        z = np.zeros((len(going), machine.width(w.shape[1])))
        z[:, :nx], z[:, nx : nx + w.shape[1]], z[:, nx + w.shape[1]] = x[going], w, 1.0
        state, tally = switches[going], np.zeros((len(going), len(TALLY)), np.int64)
        reports = np.full((len(going), count + 1, nx), np.nan)
        ended[going] = _run(bases, z, state, length, count, reports, tally, first > time[0])
        met.update(int(number) for number in bases.known if number >= 0)
        switches[going], x[going] = state, z[:, :nx]
        batch.events[here][going] += tally[:, EVENTS]
        batch.steps[here][going] += tally[:, STEPS]
        for b, k in enumerate(going):
            report(time, first, last, length, reports[b], states[k])
    return ended


def _run(
    bases: Bases, z: Array, state: Ints, length: float, count: int, reports: Array, tally: Ints, later: bool
) -> Ints:
    """Propagate all sets to the end of a stretch, making room and bases for those that need them.

    ``later``: not the first stretch, so that switches which change at its beginning are events.
    """
    origin = state.copy()
    strides = bases.steps(length)
    levels = np.array([levels_of(length / stride) for stride in strides])
    n = z.shape[1]
    machine = bases.machine
    one = len(machine.kernel.states) + bases.systems.shape[1]
    sizes = (n, one, machine.count(FRICTION), machine.most_guards)
    status, modes = np.where(strides > MOST_STEPS, TOO_SHORT, BEGINS), MODES_AT_FIRST
    todo = np.flatnonzero(status == BEGINS)[:1]  # the first shows what the others are likely to need
    while len(todo):
        _propagate(
            todo, z, state, bases.stacked, bases.known, length, strides, levels, count, reports, tally, status,
            modes, sizes, get_num_threads(), origin, later,
        )  # fmt: skip
        for number in np.unique(tally[todo, BASE][status[todo] % BEGINS == NEED_BASE]):
            if number not in bases.known:
                bases.add(int(number))
        if np.any(status == NO_ROOM):
            modes *= 2
        todo = np.flatnonzero((status % BEGINS == NEED_BASE) | (status == NO_ROOM) | (status == BEGINS))
    return status


@njit(parallel=True, cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _propagate(
    todo: Ints, z: Array, state: Ints, bases: Base, known: Ints, length: float, strides: Ints, levels: Ints, count: int,
    reports: Array, tally: Ints, status: Ints, modes: int, sizes: tuple[int, int, int, int], threads: int, origin: Ints,
    later: bool
) -> None:  # fmt: skip
    """Each thread takes every so manieth set; a set has modes of its own, so that its numbers know of no other."""
    n, one, frictions, guards = sizes
    no_events = np.empty((0, 4))
    for thread in prange(threads):
        store = room(modes, levels[todo[0]], n, one, frictions, guards)
        for k in range(thread, len(todo), threads):
            b = todo[k]
            if levels[b] != store.step.shape[1]:
                store = room(modes, levels[b], n, one, frictions, guards)
            store.made[0] = 0
            own = pick(bases, b)
            if status[b] >= BEGINS:
                found = begin(z[b], state[b], own, known, tally[b])
                if found == DONE and later:  # what a jump of the inputs changes at once
                    tally[b, EVENTS] += np.sum(state[b] != origin[b])
                status[b] = found if found == DONE else BEGINS + found
                if found != DONE:
                    continue
            status[b] = propagate(
                z[b], state[b], own, known, store, length / strides[b], count * strides[b], strides[b],
                reports[b], no_events, tally[b],
            )  # fmt: skip
