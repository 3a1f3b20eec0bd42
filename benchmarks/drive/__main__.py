"""The seed's drive with sticking, backlash and a saturated servo, simulated in several ways, beside scipy.

python -m benchmarks.drive [--write docs/simulation_speed.md]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numba
import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from benchmarks.drive.machine import seed_drive
from benchmarks.drive.reference import SINE, STEP, Mode, solve
from symdyn.numeric.hybrid import affine
from symdyn.numeric.hybrid.affine_simulation import Affine, simulate_affine
from symdyn.numeric.hybrid.batch import simulate_batch
from symdyn.numeric.hybrid.general_simulation import simulate_general
from symdyn.numeric.hybrid.signals import Signal, sine, step
from symdyn.numeric.hybrid.trajectory import HybridTrajectory

Array = NDArray[np.float64]

POINTS = 1001
CASES = {"step": (STEP, step(1.0)), "sine": (SINE, sine(1.0, 0.2))}
SETS, SPREAD = 1000, 0.1
HEADER = """# Speed of simulation with events

Written by `python -m benchmarks.drive --write docs/simulation_speed.md`; edits are lost.

The seed's drive with Coulomb friction that sticks, a clearance of 0.01 rad and a servo loop limited to 24 V: a step of
1 rad over 1 s, a sine of 1 rad and 0.2 Hz over 5 s. Error: the largest of nine states at 1001 points, over the size of
the state, against the equations written by hand (`benchmarks/drive/reference.py`, DOP853 at 1e-12). Events: changes of
friction and of contact. x: seconds simulated per second of processor time, whole calls from Python but for the first
row, the best of several runs; with set-up: the affine systems and the exponentials of all modes, too.
scipy integrates the equations by hand, in Python, from event to event, with steps of at most 2 ms.
"""


@dataclass(frozen=True)
class Row:
    name: str
    states: Array
    events: int
    seconds: float


def main() -> None:
    options = argparse.ArgumentParser(prog="python -m benchmarks.drive", description=__doc__.splitlines()[0])
    options.add_argument("--write", type=Path, metavar="FILE", help="also write the tables to a file")
    target = options.parse_args().write
    parts = [HEADER]
    with threadpool_limits(1):
        parts += [_case(name) for name in CASES]
    parts.append(_batch())
    print("\n".join(parts))
    if target is not None:
        target.write_text("\n".join(parts), encoding="utf-8")


def _case(name: str) -> str:
    case, signal = CASES[name]
    times = np.linspace(0.0, case[1], POINTS)
    expected, entered = solve(case)
    machine, kept = seed_drive(), Affine(seed_drive())
    ways: dict[str, tuple[Callable[[], tuple[Array, int]], int]] = {
        "exact, modes kept": (lambda: _ours(kept.simulate(times, [signal])), 20),
        "exact, with set-up": (lambda: _ours(simulate_affine(machine, times, [signal])), 10),
    }
    for tolerance in (1e-4, 1e-6, 1e-8):
        ways[f"general, {tolerance:g}"] = (partial(_general, times, signal, tolerance), 5)
    for method in ("LSODA", "Radau"):
        ways[f"scipy {method}, 1e-8, events"] = (partial(_scipy, case, method), 1)
    rows = [Row("exact, propagation alone", *_propagation(kept, times, signal))]
    for way, (run, repeats) in ways.items():
        states, events = run()  # compiles
        seconds = min(_thread_time(run) for _ in range(repeats))
        rows.append(Row(way, states, events, seconds))
    lines = [f"\n## {name.capitalize()}: {len(entered)} events\n", "| | error | events | x | of the exact time |",
             "| --- | ---: | ---: | ---: | ---: |"]  # fmt: skip
    size = np.abs(expected).max(axis=0)
    for row in rows:
        error = float((np.abs(row.states - expected).max(axis=0) / size).max())
        ratio = row.seconds / rows[0].seconds
        lines.append(f"| {row.name} | {error:.1e} | {row.events} | {case[1] / row.seconds:.3g} | {ratio:.3g} |")
    return "\n".join([*lines, ""])


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


def _thread_time(run: Callable[[], object]) -> float:
    start = time.thread_time()
    run()
    return time.thread_time() - start


def _ours(found: HybridTrajectory) -> tuple[Array, int]:
    """States, and changes of friction and contact; an open contact beyond its clearance is open."""
    events = [e for e in found.events if e.kind != "limit"]
    return found.states, sum(not (e.kind == "contact" and abs(e.before) == 2 and e.after == 0) for e in events)


def _general(times: Array, signal: Signal, tolerance: float) -> tuple[Array, int]:
    return _ours(simulate_general(seed_drive(), times, [signal], tolerance=tolerance))


def _scipy(case: tuple[Callable[[float], float], float], method: str) -> tuple[Array, int]:
    found: tuple[Array, list[tuple[float, Mode]]] = solve(case, POINTS, method=method, rtol=1e-8, atol=1e-10)
    return found[0], len(found[1])


def _batch() -> str:
    machine = seed_drive()
    spread = 1.0 + SPREAD * np.random.default_rng(0).uniform(-1.0, 1.0, (SETS, len(machine.kernel.parameters)))
    times, signal = np.linspace(0.0, 1.0, 101), [step(1.0)]
    run = partial(simulate_batch, machine, times, signal, parameters=machine.kernel.values * spread)
    simulate_batch(machine, times, signal)  # compiles
    used, wall = time.process_time(), time.perf_counter()
    batch = run()
    used, wall = time.process_time() - used, time.perf_counter() - wall
    failed = sum(map(bool, batch.failures))
    return (
        f"\n## Batch\n\n{SETS} sets of parameters, each within {100 * SPREAD:.0f} % of its value, the step over 1 s: "
        f"{1e3 * used / SETS:.2f} ms of processor time per set,\nexponentials included; {wall:.1f} s in all on "
        f"{numba.get_num_threads()} threads. {batch.events.sum()} events; {failed} sets failed.\n"
    )


if __name__ == "__main__":
    main()
