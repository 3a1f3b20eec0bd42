"""Exact propagation of a piecewise-affine machine, with every event located and no step taken unproven."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.affine_modes import ORDER, Base, Modes, code_of
from symdyn.numeric.hybrid.affine_switches import (
    LEVEL,
    STEP,
    STEPS,
    TICK,
    TRIES,
    enter,
    evaluate,
    find,
    round_off,
    switch,
)
from symdyn.numeric.hybrid.compiled import compiled, inlined
from symdyn.numeric.hybrid.guards import crosses_once, hopeless, margins, root
from symdyn.numeric.hybrid.trajectory import DONE, NOT_FINITE
from symdyn.numeric.hybrid.vectors import LANES, advance, times_sizes

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@inlined
def _jump(modes: Modes, mode: int, columns: int, z: Array, now: int, length: int, level: int) -> int:
    """Advance z[now : now + n] by ``length`` ticks into another third of z (3 n,), and return where it starts.

    Exponentials are applied one by one for the binary digits of the length, from 2^-level of a step downwards.
    """
    n, levels = modes.step.shape[3], modes.step.shape[1]
    at = (mode * levels + level) * n * n
    digit = 1 << (levels - 1 - level)
    one = (now + n) % (3 * n)
    two = (one + n) % (3 * n)
    while length:
        if length >= digit:
            advance(modes.step, at, n, z, now, columns, z, one)
            now, one, two = one, two, one
            length -= digit
        digit >>= 1
        at += n * n
    return now


@compiled
def propagate(
    start: Array, state: Ints, bases: Base, known: Ints, modes: Modes, horizon: float, steps: int, stride: int,
    reports: Array, events: Array, tally: Ints
) -> int:  # fmt: skip
    """Advance ``start`` (n,) and ``state`` (switches,) in place over ``steps`` steps, each ``horizon`` long.

    ``reports`` (R, nx) receives x after each ``stride`` steps. ``events`` (E, 4) receives time in steps, switch,
    state before, state after; if it is empty, they are only counted. ``tally`` is zeros at first.
    Returns DONE, or what is needed or wrong; called again it goes on from where it stopped, to the same numbers.
    """
    n, count, switches = len(start), modes.bounds.shape[2], len(state)
    columns = modes.one + 2 - modes.one % 2
    nx = reports.shape[1]
    levels = modes.step.shape[1]
    ticks = 1 << (levels - 1)
    tick = horizon / ticks
    width = ORDER * count + LANES + n
    # Places in work arrays and not arrays, which would be counted whenever they are exchanged.
    z, values = np.zeros(3 * n), np.empty(2 * width)
    now, here, there = 0, 0, width
    z[:n] = start
    bound, rounding, margin = np.empty(count), np.empty(count), np.empty(count)
    resting, before = np.zeros(bases.speeds.shape[1], np.bool_), np.empty(switches, np.int64)
    status = enter(state, bases, known, modes, horizon, tally)
    if status != DONE:
        return status
    mode = find(modes, code_of(state))
    evaluate(modes, mode, columns, z, now, values, here)
    round_off(modes, mode, columns, z, now, rounding)
    step, at = tally[STEP], tally[TICK]
    level = tally[LEVEL]
    row = step // stride  # of the last report; a division in every step would be felt
    due = (row + 1) * stride
    while True:
        fired = False
        for g in range(modes.guards[mode]):
            fired = fired or values[here + g] < -rounding[g]
        if fired:
            status = switch(
                z[now : now + n], state, bases, known, modes, horizon, mode, columns, values[here : here + width],
                rounding, resting, before, events, tally, step + at / ticks,
            )  # fmt: skip
            if status != DONE:
                break
            mode = find(modes, code_of(state))
        if at == ticks:
            at = 0
            step += 1
            if step == due:
                due, row = due + stride, row + 1
                for i in range(nx):
                    reports[row, i] = z[now + i]
            if not np.isfinite(z[now]):
                status = NOT_FINITE
                break
            if step == steps:
                break
        guards = modes.guards[mode]
        times_sizes(
            modes.bounds, mode * (LANES + n) * count, count, values, here + ORDER * count, LANES + columns, bound, 0
        )
        while True:
            reach = ticks >> level
            length = reach - (at & (reach - 1))  # ends are multiples of the reach
            h = length * tick
            if length > 1 and hopeless(values, here, guards, bound, rounding, h):
                level = _level_below(level, length, ticks)
                continue
            tally[TRIES] += 1
            new = _jump(modes, mode, columns, z, now, length, level)
            evaluate(modes, mode, columns, z, new, values, there)
            safe = margins(values, here, there, guards, bound, rounding, h, margin)
            if safe or length == 1:
                break
            simple, share = True, 1.0
            for g in range(guards):
                if margin[g] <= 0.0:
                    simple = simple and crosses_once(values, here, there, count, g, bound, rounding, h)
            if simple:
                for g in range(guards):
                    if margin[g] <= 0.0:
                        share = min(share, root(values, here, there, count, g, h))
                # Two ticks past the root of the polynomial: if that is early, the next steps are short.
                length = min(length, np.int64(share * length) + 2)
                new = _jump(modes, mode, columns, z, now, length, level)
                evaluate(modes, mode, columns, z, new, values, there)
                break
            level = _level_below(level, length, ticks)
        at += length
        tally[STEPS] += 1
        now = new
        here, there = there, here
        round_off(modes, mode, columns, z, now, rounding)
        if safe and level > 0 and 2 * length >= reach:
            level -= 1
    tally[STEP], tally[TICK], tally[LEVEL] = step, at, level
    start[:] = z[now : now + n]
    return status


@inlined
def _level_below(level: int, length: int, ticks: int) -> int:
    """The next reach to try: less than a length that failed."""
    level += 1
    while ticks >> level >= length and ticks >> level > 1:
        level += 1
    return level
