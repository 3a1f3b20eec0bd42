"""Times of all contestants in interleaved rounds, so that a change of clock speed hits all alike.

On one thread the thread's own time counts, so that a neighbour who takes the processor does not.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.speed.kernels import Contestant


@dataclass(frozen=True)
class Timing:
    """Nanoseconds per state: median, and the tenth and ninetieth percentile."""

    function: str
    form: str
    who: str
    ns: float
    low: float
    high: float


def measure(contestants: Sequence[Contestant], rounds: int) -> list[Timing]:
    """Medians over the rounds, each run right after another of its own that is not counted: caches are its own then."""
    samples: list[list[float]] = [[] for _ in contestants]
    for _ in range(rounds):
        for contestant, taken in zip(contestants, samples, strict=True):
            clock = time.perf_counter_ns if contestant.threads else time.thread_time_ns
            contestant.run()
            start = clock()
            contestant.run()
            taken.append((clock() - start) / contestant.states)
    found = []
    for contestant, taken in zip(contestants, samples, strict=True):
        tenths = statistics.quantiles(taken, n=10, method="inclusive")
        found.append(
            Timing(
                contestant.function, contestant.form, contestant.who, statistics.median(taken), tenths[0], tenths[-1]
            )
        )
    return found


def best(timings: Sequence[Timing], function: str, form: str, who: str) -> Timing | None:
    """The fastest of those whose name starts so."""
    found = [t for t in timings if (t.function, t.form) == (function, form) and t.who.startswith(who)]
    return min(found, key=lambda t: t.ns, default=None)
