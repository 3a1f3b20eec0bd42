"""20 000 points of the seed's ninth-order drive, beside python-control: processor time of one thread, interleaved.

python -m benchmarks.frequency
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np
from threadpoolctl import threadpool_limits

from symdyn.compiler import linearise, load_robot
from symdyn.derive.linearize import without_nonsmooth
from symdyn.numeric.linear.local_sensitivity import local_sensitivity
from symdyn.numeric.linear.response import frequency_response
from symdyn.numeric.linear.signals import as_control

POINTS, ROUNDS = 20_000, 7


def milliseconds() -> float:
    """Of processor time, for all points."""
    system, hertz = linearise(without_nonsmooth(load_robot("irb6-axis1"))).nominal, np.geomspace(0.1, 3000.0, POINTS)
    took = []
    for _ in range(ROUNDS):
        start = time.thread_time()
        frequency_response(system, hertz)
        took.append(1e3 * (time.thread_time() - start))
    return statistics.median(took)


def main() -> None:
    family = linearise(without_nonsmooth(load_robot("irb6-axis1")))
    system, hertz = family.nominal, np.geomspace(0.1, 3000.0, POINTS)
    theirs, s = as_control(system), 2j * np.pi * hertz
    cases: dict[str, Callable[[], object]] = {
        "symdyn": lambda: frequency_response(system, hertz),
        "python-control": lambda: theirs(s, squeeze=False),
        "symdyn, with derivatives by 21 parameters": lambda: local_sensitivity(family, hertz),
    }
    took: dict[str, list[float]] = {name: [] for name in cases}
    with threadpool_limits(1):
        for _ in range(ROUNDS):
            for name, run in cases.items():
                start = time.thread_time()
                run()
                took[name].append(time.thread_time() - start)
    for name, times in took.items():
        print(f"{name}: {1e3 * statistics.median(times):.1f} ms")
    ratios = [b / a for a, b in zip(took["symdyn"], took["python-control"], strict=True)]
    print(f"python-control / symdyn: {statistics.median(ratios):.0f}")
    error = np.abs(frequency_response(system, hertz).values / theirs(s, squeeze=False)[0, 0] - 1).max()
    print(f"largest relative difference: {error:.1e}")


if __name__ == "__main__":
    main()
