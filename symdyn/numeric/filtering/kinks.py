"""Steps across a kink (friction turns, a flank touches): how straight a machine goes on, and how far that is true."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled
from symdyn.numeric.hybrid.loops import copy
from symdyn.numeric.transition import double, transition

Array = NDArray[np.float64]
Rate = Callable[[Array, Array, Array, Array], None]

KINK = 0.005  # of a usual rate: what the slope at the start of a step does not foretell of its end
FINE = 8  # pieces of a step with a kink in it may each be off by this part of what a step may
FINEST = 1024  # pieces of a step, at most
RUNGS = 11  # lengths of pieces: 1, 2, 4, ..., FINEST
PATIENCE, HASTY = 64, 4  # pieces of one step, after which none is shorter than 2**HASTY: what chatters is not followed


@compiled
def bent(
    f: Rate, f_x: Rate, x: Array, u: Array, slope_u: Array, p: Array, rate: Array, push: Array, a: Array,
    integral: Array, h: float, limit: float, settles: float, usual: Array, there: Array, ahead: Array, arrived: Array,
    by_x: Array,
) -> bool:  # fmt: skip
    """Whether the rate after ``h`` seconds is off by more than ``limit`` usual rates from what ``a``, of [x, u], says.

    ``rate`` (n,) is f at the start, ``push`` (n,) what unknown forces add to it, ``integral`` that of exp(a t) over
    0..h. ``there`` (n,) gets the state then; ``ahead`` (nu,), ``arrived`` (n,) and ``by_x`` (n, n) are for use here.
    With ``settles`` 1.0, not 0.0, what settles far sooner than h, here and there (a body that sticks), is off no longer
    than that.
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
    known = False
    for i in range(n):
        expected = rate[i]
        for j in range(n):
            expected += a[i, j] * (there[j] - x[j])
        for j in range(nu):
            expected += a[i, n + j] * h * slope_u[j]
        off = abs(arrived[i] - expected)
        if off > limit * usual[i]:
            if settles == 0.0:
                return True
            if not known:
                known = True
                f_x(there, ahead, p, by_x)
            settling = min(-a[i, i], -by_x[i, i])
            if not off <= limit * usual[i] * (1.0 + h * max(settling, 0.0)):
                return True
    return False


@compiled
def stiffen(a: Array, x: Array, there: Array, rate: Array, arrived: Array, u_there: Array, u: Array) -> None:
    """Let ``a`` foretell the rate ``arrived`` at ``there``, where it fell short: the secant in place of the slope.

    Friction that turns within a piece stops the body there and then; a slope beside the turn would throw it across.
    """
    n, nu = len(x), len(u)
    for i in range(n):
        off = arrived[i] - rate[i]
        for j in range(n):
            off -= a[i, j] * (there[j] - x[j])
        for j in range(nu):
            off -= a[i, n + j] * (u_there[j] - u[j])
        if off * (there[i] - x[i]) < 0.0:
            a[i, i] += off / (there[i] - x[i])


@compiled
def reach(
    f: Rate, f_x: Rate, x: Array, u: Array, slope_u: Array, p: Array, rate: Array, push: Array, a: Array, na: int,
    whole: float, left: int, ramped: bool, ladder: Array, built: int, change: Array, integral: Array, ramp: Array,
    usual: Array, there: Array, ahead: Array, arrived: Array, by_x: Array, term: Array, space: Array, halves: Array,
    first: int,
) -> tuple[int, int]:  # fmt: skip
    """How many parts of ``whole`` / FINEST the machine goes straight on from here: 1, 2, 4, ..., or all ``left``.

    No fewer than 2**``first``, unless fewer are left.

    ``change``, ``integral`` and ``ramp`` get what ``transition`` gives for that far. The shorter a piece, the more its
    rate may be off: what it does to the state counts. ``ladder`` (RUNGS, 3, n, n) holds those of all lengths, the first
    ``built`` of them for this ``a``; how many are there afterwards is returned, too. Where even the shortest piece has
    a kink in it, ``a`` changes (``stiffen``).
    """
    if built == 0:
        transition(a, na, whole / FINEST, ramped, ladder[0, 0], ladder[0, 1], ladder[0, 2], term, space, halves)
        built = 1
    limit, length, rung = KINK * (FINEST / FINE), 1, 0
    while 2 * length <= left:
        if rung + 1 == built:
            for i in range(3):
                copy(ladder[rung, i], ladder[built, i])
            double(ladder[built, 0], ladder[built, 1], ladder[built, 2], na, ramped, space)
            built += 1
        if rung < first:
            length, rung = 2 * length, rung + 1
            continue
        h, after = whole * (2 * length / FINEST), ladder[rung + 1, 1]
        if bent(
            f, f_x, x, u, slope_u, p, rate, push, a, after, h, limit / (2 * length), 1.0, usual,
            there, ahead, arrived, by_x,
        ):  # fmt: skip
            break
        length, rung = 2 * length, rung + 1
    if length < left < 2 * length:
        h = whole * (left / FINEST)
        transition(a, na, h, ramped, change, integral, ramp, term, space, halves)
        if not bent(
            f, f_x, x, u, slope_u, p, rate, push, a, integral, h, limit / left, 1.0, usual,
            there, ahead, arrived, by_x,
        ):  # fmt: skip
            return left, built
    if rung <= first:
        h, after = whole * (length / FINEST), ladder[rung, 1]
        if bent(f, f_x, x, u, slope_u, p, rate, push, a, after, h, KINK, 1.0, usual, there, ahead, arrived, by_x):
            stiffen(a, x, there, rate, arrived, ahead, u)
            own = ladder[rung]
            transition(a, na, h, ramped, own[0], own[1], own[2], term, space, halves)
            built = 0
    copy(ladder[rung, 0], change)
    copy(ladder[rung, 1], integral)
    copy(ladder[rung, 2], ramp)
    return length, built
