"""Steps across a kink (friction turns, a flank touches): how straight a machine goes on, and how far that is true."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.transition import double, transition
from symdyn.numeric.hybrid.compiled import compiled

Array = NDArray[np.float64]
Rate = Callable[[Array, Array, Array, Array], None]

KINK = 0.02  # of a usual rate: what the slope at the start of a step does not foretell of its end
FINE = 16  # pieces of a step with a kink in it may each be off by this part of what a step may
FINEST = 1024  # pieces of a step, at most


@compiled
def bent(
    f: Rate, x: Array, u: Array, slope_u: Array, p: Array, rate: Array, push: Array, a: Array, integral: Array,
    h: float, usual: Array, there: Array, ahead: Array, arrived: Array,
) -> float:  # fmt: skip
    """How far off the rate after ``h`` seconds is from what ``a``, of [x, u], foretells: in ``usual`` rates, the most.

    ``rate`` (n,) is f at the start, ``push`` (n,) what unknown forces add to it, ``integral`` that of exp(a t) over
    0..h. ``there`` (n,) gets the state then; ``ahead`` (nu,) and ``arrived`` (n,) are for use here.
    """
    n, nu = len(x), len(u)
    for i in range(n):
        there[i] = x[i]
        for j in range(n):
            there[i] += integral[i, j] * (rate[j] + push[j])
        for j in range(nu):
            there[i] += integral[i, n + j] * slope_u[j]
    for j in range(nu):
        ahead[j] = u[j] + h * slope_u[j]
    f(there, ahead, p, arrived)
    most = 0.0
    for i in range(n):
        expected = rate[i]
        for j in range(n):
            expected += a[i, j] * (there[j] - x[j])
        for j in range(nu):
            expected += a[i, n + j] * h * slope_u[j]
        off = abs(arrived[i] - expected)
        if off > most * usual[i]:
            most = off / usual[i] if usual[i] > 0.0 else np.inf
    return most


@compiled
def reach(
    f: Rate, x: Array, u: Array, slope_u: Array, p: Array, rate: Array, push: Array, a: Array, na: int, whole: float,
    left: int, ramped: bool, change: Array, integral: Array, ramp: Array, change_1: Array, integral_1: Array,
    ramp_1: Array, usual: Array, there: Array, ahead: Array, arrived: Array, term: Array, space: Array, halves: Array,
) -> int:  # fmt: skip
    """How many parts of ``whole`` / FINEST the machine goes straight on from here: 1, 2, 4, ..., no more than ``left``.

    ``change``, ``integral`` and ``ramp`` get what ``transition`` gives for that far. The shorter a piece, the more its
    rate may be off: what it does to the state counts.
    """
    transition(a, na, whole / FINEST, ramped, change, integral, ramp, term, space, halves)
    length = 1
    while 2 * length <= left:
        change_1[:], integral_1[:], ramp_1[:] = change, integral, ramp
        double(change, integral, ramp, na, ramped, space)
        h = whole * (2 * length / FINEST)
        off = bent(f, x, u, slope_u, p, rate, push, a, integral, h, usual, there, ahead, arrived)
        if off * 2 * length > KINK * (FINEST / FINE):
            change[:], integral[:], ramp[:] = change_1, integral_1, ramp_1
            break
        length *= 2
    return length
