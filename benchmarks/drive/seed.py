"""The seed's drive with sticking, backlash and a saturated servo, simulated in several ways, beside CVODE and scipy."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import pi
from unittest.mock import patch

import numba
import numpy as np
from numpy.typing import NDArray

from benchmarks.drive.cvode import Wave, solve_with_cvode
from benchmarks.drive.machine import seed_drive
from benchmarks.drive.measure import Row, error, measured
from benchmarks.drive.reference import SINE, STEP, solve
from symdyn.numeric.hybrid import affine
from symdyn.numeric.hybrid.affine_simulation import Affine, simulate_affine
from symdyn.numeric.hybrid.batch import simulate_batch
from symdyn.numeric.hybrid.general_simulation import simulate_general
from symdyn.numeric.hybrid.signals import Signal, sine, step
from symdyn.numeric.hybrid.trajectory import HybridTrajectory

Array = NDArray[np.float64]
Case = tuple[tuple[Callable[[float], float], float], Signal, Wave]

POINTS = 1001
CASES: dict[str, Case] = {
    "step": (STEP, step(1.0), (1.0, 0.0, 0.0)),
    "sine": (SINE, sine(1.0, 0.2), (0.0, 1.0, 2 * pi * 0.2)),
}
SPREAD = 0.1


@dataclass(frozen=True)
class Batch:
    sets: int
    processor: float  # s
    wall: float  # s
    threads: int
    events: int
    failed: int


def simulate_case(name: str) -> tuple[list[Row], int]:
    """The rows of a case: our propagation alone first, then whole calls, then the peers; and the events there are."""
    case, signal, wave = CASES[name]
    times = np.linspace(0.0, case[1], POINTS)
    reference, entered = solve(case)
    machine, kept = seed_drive(), Affine(seed_drive())
    states, events, seconds = _propagation(kept, times, signal)
    rows = [Row("exact, propagation alone", error(states, reference), events, case[1] / seconds)]

    def add(name: str, run: Callable[[], tuple[Array, int]], repeats: int) -> None:
        rows.append(measured(name, run, reference, case[1], repeats))

    add("exact, modes kept", lambda: _ours(kept.simulate(times, [signal])), 20)
    add("exact, with set-up", lambda: _ours(simulate_affine(machine, times, [signal])), 10)
    for tolerance in (1e-4, 1e-6, 1e-8):
        general = partial(simulate_general, machine, times, [signal], tolerance=tolerance)
        add(f"general, {tolerance:g}", lambda general=general: _ours(general()), 5)  # type: ignore[misc]
    for tolerance in (1e-6, 1e-8, 1e-9, 1e-10):
        add(f"CVODE, {tolerance:g}", partial(solve_with_cvode, wave, case[1], POINTS, tolerance), 2)
    for method, tolerance in (("LSODA", 1e-8), ("Radau", 1e-7)):
        add(f"scipy {method}, {tolerance:g}", partial(_scipy, case, method, tolerance), 0)
    return rows, len(entered)


def simulate_sets(sets: int) -> Batch:
    """The step over 1 s of as many sets of parameters, each within 10 % of its value, on all threads."""
    machine = seed_drive()
    spread = 1.0 + SPREAD * np.random.default_rng(0).uniform(-1.0, 1.0, (sets, len(machine.kernel.parameters)))
    times, signal = np.linspace(0.0, 1.0, 101), [step(1.0)]
    simulate_batch(machine, times, signal)  # compiles
    used, wall = time.process_time(), time.perf_counter()
    batch = simulate_batch(machine, times, signal, parameters=machine.kernel.values * spread)
    used, wall = time.process_time() - used, time.perf_counter() - wall
    failed = sum(map(bool, batch.failures))
    return Batch(sets, used, wall, numba.get_num_threads(), int(batch.events.sum()), failed)


def _propagation(kept: Affine, times: Array, signal: Signal) -> tuple[Array, int, float]:
    """States, events and time of the compiled propagation, without the Python around it."""
    kept.simulate(times, [signal])
    inner, spent = affine.propagate, [0.0]

    def timed(*arguments: object) -> int:
        start = time.thread_time()
        status = int(inner(*arguments))
        spent[-1] += time.thread_time() - start
        return status

    with patch.object(affine, "propagate", timed):
        for _ in range(20):
            spent.append(0.0)
            found = kept.simulate(times, [signal])
    return *_ours(found), min(spent[1:])


def _ours(found: HybridTrajectory) -> tuple[Array, int]:
    """States, and changes of friction and contact; an open contact beyond its clearance is open."""
    events = [e for e in found.events if e.kind != "limit"]
    return found.states, sum(not (e.kind == "contact" and abs(e.before) == 2 and e.after == 0) for e in events)


def _scipy(case: tuple[Callable[[float], float], float], method: str, tolerance: float) -> tuple[Array, int]:
    states, entered = solve(case, POINTS, method=method, rtol=tolerance, atol=1e-2 * tolerance)
    return states, len(entered)
