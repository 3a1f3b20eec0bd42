"""Simulation with located events beside CVODE and scipy: what is to be reached, what is, and how it was measured.

python -m benchmarks.drive [--sets 10000] [--write docs/simulation_speed.md]
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from threadpoolctl import threadpool_limits

from benchmarks import frequency
from benchmarks.drive import arms, seed
from benchmarks.drive.measure import Row, table

HEADER = """# Speed of simulation with events

Written by `python -m benchmarks.drive --write docs/simulation_speed.md`; edits are lost.

*Seed drive*: that of the paper with Coulomb friction that sticks, a clearance of 0.01 rad and a servo loop limited to
24 V; a step of 1 rad over 1 s, a sine of 1 rad and 0.2 Hz over 5 s. *Arm*: `irb6-arm-drives`, two such drives with an
arm, 18 states, the same references on both axes. *Puma 560*: with six drives with friction and a computed-torque loop
at 1 kHz.

x real time: seconds simulated per second of processor time of one thread, the best of several runs (one of scipy's).
Error: the largest of all states at 1001 points, over the size of the state. References: for the seed drive the
equations written by hand, by DOP853 at 1e-12; for the arm's step and the Puma (its first 0.5 s) DOP853 at 1e-10 with
events; for the arm's sine our own method at 1e-12. Events of the seed drive: changes of friction and of contact.

CVODE is scikit-sundae's: BDF with root finding from event to event, the Jacobian given, equations by hand in Numba.
scipy integrates the seed's equations by hand in Python, and the arm's emitted functions, from event to event.
"Propagation alone": the compiled part of a call, with the exponentials of the modes at hand; "modes kept": whole calls
from Python on a machine that was simulated before; "with set-up": on one that was not.
"""


def main() -> None:
    options = argparse.ArgumentParser(prog="python -m benchmarks.drive", description=__doc__.splitlines()[0])
    options.add_argument("--sets", type=int, default=1000, help="sets of parameters in the batch (default 1000)")
    options.add_argument("--write", type=Path, metavar="FILE", help="also write the tables to a file")
    asked = options.parse_args()
    with threadpool_limits(1):
        cases = {name: seed.simulate_case(name) for name in seed.CASES}
        arm = {name: arms.arm_rows(name) for name in arms.CASES}
        puma = arms.computed_torque_rows()
        response = frequency.milliseconds()
    batch = seed.simulate_sets(asked.sets)
    text = "\n".join([
        HEADER,
        _targets(cases, arm["step"], puma, batch, response),
        *(table(f"Seed drive, {name}: {count} events", rows) for name, (rows, count) in cases.items()),
        *(table(f"Arm, {name}", rows) for name, rows in arm.items()),
        table("Puma 560", puma),
        f"## Batch\n\n{batch.sets} sets of parameters, each within {100 * seed.SPREAD:.0f} % of its value, the step\n"
        f"over 1 s: {1e3 * batch.processor / batch.sets:.2f} ms of processor time per set, exponentials included; "
        f"{batch.wall:.1f} s in all\non {batch.threads} threads. {batch.events} events; {batch.failed} sets failed.\n",
    ])  # fmt: skip
    print(text)
    if asked.write is not None:
        asked.write.write_text(text, encoding="utf-8")


def _targets(
    cases: dict[str, tuple[list[Row], int]], arm: Sequence[Row], puma: Sequence[Row], batch: seed.Batch, response: float
) -> str:
    lines = ["## What was to be reached", "", "| | asked | reached |", "| --- | ---: | ---: |"]
    for (name, (rows, events)), asked in zip(cases.items(), ("3000", "6000"), strict=True):
        alone, kept = rows[0], rows[1]
        peer = closest([row for row in rows if row.name.startswith("CVODE")], 1e-7)
        lines += [
            f"| seed drive, {name}: x real time at 1e-7, propagation alone / modes kept | {asked} | "
            f"{alone.speed:.0f} / {kept.speed:.0f} at {alone.error:.0e} |",
            f"| the same against CVODE at {peer.error:.0e} | 500 | "
            f"{alone.speed / peer.speed:.0f} / {kept.speed / peer.speed:.0f} |",
            f"| events found, proven that none is missed | {events} | {alone.events} |",
        ]
    ours = closest([row for row in arm if row.name.startswith("symdyn")], 1e-6)
    best = max((row for row in arm if row.name.startswith("scipy") and row.error < 3e-6), key=lambda row: row.speed)
    ms = 1e3 * batch.processor / batch.sets
    lines += [
        f"| arm with two drives, step: x real time at 1e-6 | 100 | {ours.speed:.0f} at {ours.error:.0e} |",
        f"| the same against the fastest of scipy, at {best.error:.0e} | 40 | {ours.speed / best.speed:.0f} |",
        f"| Puma 560, computed torque at 1 kHz: x real time | 300 | {puma[0].speed:.0f} at {puma[0].error:.0e} |",
        f"| 10 000 sets of the seed drive, 1 s each, both cores, s | 30 | {10_000 / batch.sets * batch.wall:.1f} by "
        f"the clock, {10 * ms / 2:.1f} of each processor (from {batch.sets}) |",
        f"| frequency response, 20 000 points, 9th order, ms | 50 | {response:.1f} |",
    ]
    return "\n".join([*lines, ""])


def closest(rows: Sequence[Row], error: float) -> Row:
    """The least exact row that is as good as ``error``, within a tenth of a power of ten; else the most exact one."""
    good = [row for row in rows if row.error <= 1.25 * error]
    return max(good, key=lambda row: row.error) if good else min(rows, key=lambda row: row.error)


if __name__ == "__main__":
    main()
