"""Steps across a kink (friction turns, a flank touches): how straight a machine goes on, and how far that is true."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled
from symdyn.numeric.transition import HALVES, double, transition

Array = NDArray[np.float64]
Rate = Callable[[Array, Array, Array, Array], None]

KINK = 0.005  # of a usual rate: what the slope at the start of a step does not foretell of its end
FINE = 8  # pieces of a step with a kink in it may each be off by this part of what a step may
FIRST, SHORTEST = 2.0**-6, 2.0**-10  # of a step: pieces that are tried first; and those that may be
RUNGS = 1 - round(math.log2(SHORTEST)) + HALVES  # of a ladder: a step, its halves to the shortest piece, and of that
PATIENCE, HASTY = (
    64,
    2.0**-6,
)  # pieces of one step, after which none is shorter than that: what chatters is not followed
STIFFEST = 1e9  # settlings within a piece: what stands as a force hits it has no slope, and that no exponential


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
def stiffen(a: Array, x: Array, there: Array, rate: Array, arrived: Array, u_there: Array, u: Array, h: float) -> None:
    """Let ``a`` foretell the rate ``arrived`` at ``there``, ``h`` s later, where it fell short: by the secant.

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
            a[i, i] += max(off / (there[i] - x[i]), -STIFFEST / h)


@compiled
def reach(
    f: Rate, f_x: Rate, x: Array, u: Array, slope_u: Array, p: Array, rate: Array, push: Array, a: Array, na: int,
    whole: float, left: float, shortest: float, ramped: bool, ladder: Array, many: int, usual: Array, there: Array,
    ahead: Array, arrived: Array, by_x: Array, term: Array, space: Array,
) -> tuple[float, int]:  # fmt: skip
    """Which part of a step of ``whole`` the machine goes straight on from here, and the rung of ``ladder`` with that.

    Parts are what is ``left`` (1 at the start), or a half of it, a quarter, ...; none is shorter than ``shortest``,
    unless that is all that is left. A longer one is tried after a shorter one: its end alone does not tell what a
    machine did on the way. The shorter a piece, the more its rate may be off: what it does to the state counts.

    ``ladder`` (RUNGS, 3, n, n) is that of ``transition`` for ``left``, with ``many`` halves; or -1, where ``a`` is new.
    Where even the shortest piece has a kink in it, ``a`` changes (``stiffen``).
    """
    rung, limit = 0, KINK / FINE
    while left * 0.5**rung > max(FIRST, shortest):
        rung += 1
    built = rung <= many
    part = left * 0.5**rung
    while True:
        if not built:
            transition(a, na, whole * part, ramped, ladder[rung:], term, space)
        if not bent(
            f, f_x, x, u, slope_u, p, rate, push, a, ladder[rung, 1], whole * part, limit / part, 1.0, usual,
            there, ahead, arrived, by_x,
        ):  # fmt: skip
            break
        if 0.5 * part < shortest:
            if bent(
                f, f_x, x, u, slope_u, p, rate, push, a, ladder[rung, 1], whole * part, KINK, 1.0, usual,
                there, ahead, arrived, by_x,
            ):  # fmt: skip
                stiffen(a, x, there, rate, arrived, ahead, u, whole * part)
                transition(a, na, whole * part, ramped, ladder[rung:], term, space)
            return part, rung
        built = False
        while 0.5 * part >= shortest:
            part, rung = 0.5 * part, rung + 1
    while rung > 0:
        if not built:
            double(ladder[rung], ladder[rung - 1], na, ramped)
        if bent(
            f, f_x, x, u, slope_u, p, rate, push, a, ladder[rung - 1, 1], whole * 2.0 * part, limit / (2.0 * part), 1.0,
            usual, there, ahead, arrived, by_x,
        ):  # fmt: skip
            break
        part, rung = 2.0 * part, rung - 1
    return part, rung
