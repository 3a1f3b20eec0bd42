"""Batches of what is not propagated together: arms, and machines with sampled loops, each simulated as it is alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import chain

import numpy as np
from numba import get_num_threads
from numpy.typing import NDArray

from symdyn.base.errors import NumericalError
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.signals import Signal
from symdyn.numeric.hybrid.simulate import simulate_events
from symdyn.numeric.hybrid.trajectory import HybridTrajectory

Array = NDArray[np.float64]
Found = HybridTrajectory | str  # what became of one set; a text says why nothing


def simulate_singly(
    machine: Machine,
    time: Array,
    each: Sequence[Sequence[Signal]],
    parameters: Array | None,
    starts: Array,
    progress: Callable[[int, int], None] | None,
) -> list[Found]:
    """One after the other for every thread of Numba; ``each`` one list of signals, or one for every set.

    ``starts`` (B, nx), ``parameters`` (B, np) for machines that are affine in every mode. Compiled code runs side by
    side, what surrounds it (each sample of a sampled loop) does not.
    """
    sets = len(starts)

    def one(k: int) -> Found:
        of = machine if parameters is None else replace(machine, p=np.ascontiguousarray(parameters[k]))
        try:
            return simulate_events(of, time, each[k % len(each)], start=starts[k])
        except NumericalError as error:
            return "; ".join(problem.message for problem in error.problems)

    found = []
    first = one(0) if sets else None  # compiles, once
    with ThreadPoolExecutor(get_num_threads()) as pool:
        rest = pool.map(one, range(1, sets))
        for result in rest if first is None else chain([first], rest):
            found.append(result)
            if progress is not None:
                progress(len(found), sets)
    return found
