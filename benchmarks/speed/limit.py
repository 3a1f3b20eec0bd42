"""What the multipliers of a processor allow: batches can be no faster than their products, however the rest is done."""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np
from numba import njit

from symdyn.program.cost import Cost

LANES, LENGTH, TURNS, ROUNDS = 64, 10, 2000, 30
CHAINS = 4  # that do not wait for one another: a product takes several cycles, of which one begins in each
OF_AN_ANGLE = 18  # products of a sine and its cosine (reduction 4, two polynomials 14)


def products(cost: Cost) -> int:
    """Of one state, those inside sines and cosines with them; each may take a sum along."""
    return cost.multiplications + OF_AN_ANGLE * cost.trigonometric // 2


@njit(error_model="numpy", fastmath={"contract"})
def _chains(x: Any, a: float, b: float, out: Any) -> None:
    for _ in range(TURNS):
        for k in range(LANES):
            s, t, v, w = x[k], x[k] + a, x[k] - a, x[k] + b
            for _ in range(LENGTH):
                s, t, v, w = s * a + b, t * b + a, v * a + a, w * b + b
            out[k] = s + t + v + w


def nanoseconds_of_a_product() -> float:
    """Of one thread and one state, where vectors are full and nothing else is done: a product with a sum."""
    x, out, spent = np.linspace(0.0, 1.0, LANES), np.zeros(LANES), []
    _chains(x, 0.5, 0.25, out)
    for _ in range(ROUNDS):
        start = time.thread_time_ns()
        _chains(x, 0.5, 0.25, out)
        spent.append((time.thread_time_ns() - start) / (TURNS * LANES * LENGTH * CHAINS))
    return statistics.median(spent)
