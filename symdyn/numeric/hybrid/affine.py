"""Exact propagation of a piecewise-affine machine, with every event located and no step taken unproven."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.affine_modes import ORDER, Base, Modes, add_mode, code_of
from symdyn.numeric.hybrid.compiled import compiled
from symdyn.numeric.hybrid.friction_modes import friction_at_rest
from symdyn.numeric.hybrid.trajectory import CHATTERS, DONE, NEED_BASE, NO_ROOM, NOT_FINITE, TOO_MANY

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

ROUNDING = 1e-14
HERMITE_8 = 1.0 / (256.0 * 40320.0)  # of the remainder h^8 g^(8) of the interpolation by two ends
HERMITE_7 = 0.00839 / 40320.0  # the same over the time since a root at the start
SAME_INSTANT = 64  # switches at one instant before it is called chattering


@compiled
def _advance(step: Array, mode: int, level: int, z: Array, out: Array) -> None:
    """out = z + F z; four columns at a time, which is what n is a multiple of."""
    n = len(z)
    for i in range(n):
        out[i] = z[i]
    for j in range(0, n, 4):
        z0, z1, z2, z3 = z[j], z[j + 1], z[j + 2], z[j + 3]
        for i in range(n):
            out[i] += (step[mode, level, j, i] * z0 + step[mode, level, j + 1, i] * z1) + (
                step[mode, level, j + 2, i] * z2 + step[mode, level, j + 3, i] * z3
            )


@compiled
def _times(transposed: Array, mode: int, z: Array, out: Array) -> None:
    """out = rows z."""
    width = len(out)
    for i in range(width):
        out[i] = 0.0
    for j in range(0, len(z), 4):
        z0, z1, z2, z3 = z[j], z[j + 1], z[j + 2], z[j + 3]
        for i in range(width):
            out[i] += (transposed[mode, j, i] * z0 + transposed[mode, j + 1, i] * z1) + (
                transposed[mode, j + 2, i] * z2 + transposed[mode, j + 3, i] * z3
            )


@compiled
def _sizes(modes: Modes, mode: int, z: Array, values: Array, bound: Array, rounding: Array) -> None:
    """Bounds of the guards' eighth derivatives over any step from z, and what rounding makes of the guards."""
    count = len(bound)
    for g in range(count):
        bound[g] = 0.0
        rounding[g] = 0.0
    for j in range(len(z)):
        rate, size = abs(values[ORDER * count + j]), ROUNDING * abs(z[j])
        for g in range(count):
            bound[g] += modes.bounds[mode, j, g] * rate
            rounding[g] += modes.sizes[mode, j, g] * size


@compiled
def _margins(g0: Array, g1: Array, bound: Array, rounding: Array, h: float, margin: Array) -> None:
    """How far each guard stays above zero over a step of length ``h``; negative or zero: not proven.

    ``g0`` and ``g1`` (4 G,) are guards and three derivatives at both ends, ``bound`` (G,) is on the eighth.
    The polynomial of degree 7 through both ends is above its least Bernstein coefficient, and the
    guard within the remainder of it. A guard that starts at its root is divided by the time since.
    """
    count = len(margin)
    for g in range(count):
        p0, p1 = g0[g], g1[g]
        a1, a2, a3 = g0[count + g] * h / 7.0, g0[2 * count + g] * h * h / 42.0, g0[3 * count + g] * h * h * h / 210.0
        c1, c2, c3 = g1[count + g] * h / 7.0, g1[2 * count + g] * h * h / 42.0, g1[3 * count + g] * h * h * h / 210.0
        b1, b2, b3 = p0 + a1, p0 + 2.0 * a1 + a2, p0 + 3.0 * a1 + 3.0 * a2 + a3
        b6, b5, b4 = p1 - c1, p1 - 2.0 * c1 + c2, p1 - 3.0 * c1 + 3.0 * c2 - c3
        remainder = bound[g] * h * h * h * h * h * h * h * h
        least = min(min(min(p0, b1), min(b2, b3)), min(min(b4, b5), min(b6, p1)))
        slope = min(
            min(min(b1 * 7.0, b2 * 3.5), min(b3 * 2.3333333333333335, b4 * 1.75)),
            min(min(b5 * 1.4, b6 * 1.1666666666666667), p1),
        )
        fresh = abs(p0) <= rounding[g]
        margin[g] = (slope - HERMITE_7 * remainder) if fresh else (least - HERMITE_8 * remainder - rounding[g])


@compiled
def _root(g0: Array, g1: Array, count: int, g: int, h: float) -> float:
    """Where in (0, 1] the polynomial through both ends of a step, positive at 0 and negative at 1, is zero."""
    a1, a2, a3 = g0[count + g] * h / 7.0, g0[2 * count + g] * h * h / 42.0, g0[3 * count + g] * h * h * h / 210.0
    c1, c2, c3 = g1[count + g] * h / 7.0, g1[2 * count + g] * h * h / 42.0, g1[3 * count + g] * h * h * h / 210.0
    p0, p1 = g0[g], g1[g]
    b = (p0, p0 + a1, p0 + 2.0 * a1 + a2, p0 + 3.0 * a1 + 3.0 * a2 + a3,
         p1 - 3.0 * c1 + 3.0 * c2 - c3, p1 - 2.0 * c1 + c2, p1 - c1, p1)  # fmt: skip
    low, high, at_low, at_high = 0.0, 1.0, p0, p1
    side = 0
    for _ in range(60):  # Illinois
        s = (low * at_high - high * at_low) / (at_high - at_low)
        r = 1.0 - s
        value = r * r * r * r * (
            r * r * r * b[0] + 7.0 * r * r * s * b[1] + 21.0 * r * s * s * b[2] + 35.0 * s * s * s * b[3]
        ) + s * s * s * s * (
            35.0 * r * r * r * b[4] + 21.0 * r * r * s * b[5] + 7.0 * r * s * s * b[6] + s * s * s * b[7]
        )
        if value > 0.0:
            low, at_low = s, value
            if side == 1:
                at_high *= 0.5
            side = 1
        else:
            high, at_high = s, value
            if side == -1:
                at_low *= 0.5
            side = -1
        if high - low < 1e-9 or value == 0.0:
            break
    return high


@compiled
def _find(modes: Modes, code: int) -> int:
    for k in range(modes.made[0]):
        if modes.codes[k] == code:
            return k
    return -1


@compiled
def base_of(state: Ints, frictions: int, contacts: int) -> int:
    """Number of the combination of contacts and limits, three states each."""
    number = 0
    for k in range(frictions, len(state)):
        value = state[k]
        if k < frictions + contacts and abs(value) == 2:
            value = 0
        number = number * 3 + value + 1
    return number


@compiled
def _jump(modes: Modes, mode: int, z: Array, length: int, out: Array, spare: Array) -> None:
    """out = z after ``length`` ticks: a product of the exponentials of its binary digits."""
    level = modes.step.shape[1] - 1
    for i in range(len(z)):
        out[i] = z[i]
    while length:
        if length & 1:
            _advance(modes.step, mode, level, out, spare)
            for i in range(len(z)):
                out[i] = spare[i]
        length >>= 1
        level -= 1


@compiled
def propagate(
    start: Array, state: Ints, bases: Base, known: Ints, modes: Modes, horizon: float, first: int, last: int,
    every: Array, events: Array, tally: Ints
) -> int:  # fmt: skip
    """Advance ``start`` (n,) and ``state`` (switches,) in place from step ``first`` to ``last``, each ``horizon`` long.

    ``every`` (steps + 1, n) receives z after each step. ``events`` (E, 4) receives time in steps, switch,
    state before, state after; ``tally`` is [events, steps proven, tries, next step, tick within it].
    Returns DONE, or what is needed or wrong; called again it goes on from where it stopped.
    """
    z = start.copy()
    n, count = len(z), modes.bounds.shape[2]
    ticks = 1 << (modes.step.shape[1] - 1)
    tick = horizon / ticks
    width = ORDER * count + n
    here, there = np.empty(width), np.empty(width)
    new, spare = np.empty(n), np.empty(n)
    bound, rounding, margin = np.empty(count), np.empty(count), np.empty(count)
    status = _enter(z, state, bases, known, modes, horizon)
    if status != DONE:
        return status
    mode = _find(modes, code_of(state))
    _times(modes.rows, mode, z, here)
    _sizes(modes, mode, z, here, bound, rounding)
    reach = ticks
    for step in range(first, last):
        at = tally[4]
        tally[3], tally[4] = step, 0
        while at < ticks:
            fired = -1
            while True:
                tally[2] += 1
                length = (at // reach + 1) * reach - at  # ends are multiples of the reach
                h = length * tick
                _jump(modes, mode, z, length, new, spare)
                _times(modes.rows, mode, new, there)
                _margins(here, there, bound, rounding, h, margin)
                safe, simple = True, True
                for g in range(count):
                    if margin[g] <= 0.0:
                        safe = False
                        down = there[g] < -rounding[g] and here[g] > rounding[g]
                        small = HERMITE_8 * bound[g] * h**8 < 1e-9 * (here[g] - there[g])
                        simple = simple and down and small
                if safe or length == 1:
                    break
                if simple:
                    share = 1.0
                    for g in range(count):
                        if margin[g] <= 0.0:
                            share = min(share, _root(here, there, count, g, h))
                    # Two ticks past the root of the polynomial: if that is early, the next steps are short.
                    length = min(length, np.int64(share * length) + 2)
                    _jump(modes, mode, z, length, new, spare)
                    _times(modes.rows, mode, new, there)
                    break
                reach = max(1, min(reach >> 1, _power_below(length)))
            at += length
            tally[1] += 1
            z, new = new, z
            here, there = there, here
            _sizes(modes, mode, z, here, bound, rounding)
            for g in range(count):
                if here[g] < -rounding[g]:
                    fired = g
            if fired < 0:
                if safe and reach < ticks and length >= reach >> 1:
                    reach <<= 1
                continue
            status = _switch(z, state, bases, known, modes, horizon, mode, here, events, tally, step + at / ticks)
            if status != DONE:
                tally[3], tally[4] = step, at
                start[:] = z
                return status
            mode = _find(modes, code_of(state))
            _times(modes.rows, mode, z, here)
            _sizes(modes, mode, z, here, bound, rounding)
        for i in range(n):
            every[step + 1, i] = z[i]
        if not np.isfinite(z[0]):
            return NOT_FINITE
    tally[3] = last
    start[:] = z
    return DONE


@compiled
def _power_below(length: int) -> int:
    """The largest power of two below ``length``."""
    power = 1
    while 2 * power < length:
        power *= 2
    return power


@compiled
def pick(bases: Base, number: int) -> Base:
    """One of stacked bases."""
    return Base(
        bases.a[number], bases.friction[number], bases.speeds[number], bases.gap[number], bases.high[number],
        bases.low[number], bases.argument[number], bases.gap_half[number], bases.limits[number],
    )  # fmt: skip


@compiled
def begin(z: Array, state: Ints, bases: Base, known: Ints) -> int:
    """Set ``state`` to what holds at ``z``: at the start, and after a jump of the inputs. Returns DONE or NEED_BASE."""
    nf, nc = bases.speeds.shape[1], bases.gap.shape[1]
    for _ in range(2 * len(state) + 1):  # what is limited may depend on other limits
        number = known[base_of(state, nf, nc)]
        if number < 0:
            return NEED_BASE
        base = pick(bases, number)
        changed = False
        for k in range(nf, len(state)):
            now = _held(z, base, k - nf, k - nf - nc)
            changed = changed or now != state[k]
            state[k] = now
        if not changed:
            break
    resting = np.zeros(nf, np.bool_)
    for k in range(nf):
        speed = 0.0
        for i in range(len(z)):
            speed += base.speeds[k, i] * z[i]
        resting[k] = speed == 0.0
        state[k] = np.int64(np.sign(speed))
    _settle(z, state, base, resting)
    return DONE


@compiled
def _held(z: Array, base: Base, contact: int, limit: int) -> int:
    """The state of a contact, or of a limit where ``limit`` is not negative."""
    if limit >= 0:
        value = base.argument[limit] @ z
        return 1 if value > base.limits[limit, 1] else (-1 if value < base.limits[limit, 0] else 0)
    twist = base.gap[contact] @ z
    if abs(twist) <= base.gap_half[contact]:
        return 0
    press = base.high[contact] @ z if twist > 0.0 else base.low[contact] @ z
    return (1 if twist > 0.0 else -1) * (1 if press > 0.0 else 2)


@compiled
def _enter(z: Array, state: Ints, bases: Base, known: Ints, modes: Modes, horizon: float) -> int:
    """See that the mode of ``state`` is made."""
    if _find(modes, code_of(state)) >= 0:
        return DONE
    number = known[base_of(state, bases.speeds.shape[1], bases.gap.shape[1])]
    if number < 0:
        return NEED_BASE
    return DONE if add_mode(modes, pick(bases, number), state, horizon) >= 0 else NO_ROOM


@compiled
def _switch(
    z: Array, state: Ints, bases: Base, known: Ints, modes: Modes, horizon: float, mode: int, values: Array,
    events: Array, tally: Ints, time: float
) -> int:  # fmt: skip
    """Change the switches whose guards have been crossed, until all guards of the mode that results hold."""
    nf = bases.speeds.shape[1]
    resting = np.zeros(nf, np.bool_)  # frictions whose speed is zero now
    for k in range(nf):
        resting[k] = state[k] == 0
    before = state.copy()
    for turn in range(SAME_INSTANT):
        crossed = False
        for g in range(modes.guards[mode]):
            k = modes.owner[mode, g]
            if _violated(modes, mode, g, z, values, turn == 0):
                crossed = True
                if k < nf:
                    resting[k] = True
                else:
                    state[k] = modes.target[mode, g]
        if not crossed and turn > 0:
            break
        number = known[base_of(state, nf, bases.gap.shape[1])]
        if number < 0:
            state[:] = before
            return NEED_BASE
        _settle(z, state, pick(bases, number), resting)
        status = _enter(z, state, bases, known, modes, horizon)
        if status != DONE:
            state[:] = before
            return status
        mode = _find(modes, code_of(state))
        _times(modes.rows, mode, z, values)
    else:
        return CHATTERS
    for k in range(len(state)):
        if state[k] != before[k]:
            if tally[0] == len(events):
                return TOO_MANY
            events[tally[0], 0] = time
            events[tally[0], 1] = k
            events[tally[0], 2] = before[k]
            events[tally[0], 3] = state[k]
            tally[0] += 1
    return DONE


@compiled
def _violated(modes: Modes, mode: int, g: int, z: Array, values: Array, arriving: bool) -> bool:
    """Whether a guard is negative, or zero and about to be (not for one that has just been reached)."""
    rounding = 0.0
    for i in range(len(z)):
        rounding += modes.sizes[mode, i, g] * abs(z[i])
    rounding *= ROUNDING
    count = modes.bounds.shape[2]
    value = values[g]
    if value < -rounding:
        return True
    if arriving or value > rounding:
        return False
    for order in range(1, ORDER):
        rate = values[order * count + g]
        if rate != 0.0:
            return bool(rate < 0.0)
    return False


@compiled
def _settle(z: Array, state: Ints, base: Base, resting: Any) -> None:
    """Put speeds that have come to zero there exactly, and decide who sticks and who sets off which way."""
    at_rest = np.nonzero(resting)[0]
    m = len(at_rest)
    if m == 0:
        return
    n = len(z)
    speeds, pull = np.empty((m, n)), np.empty((n, m))
    for r in range(m):
        speeds[r] = base.speeds[at_rest[r]]
        pull[:, r] = base.friction[:, at_rest[r]]
    drag = speeds @ pull
    z -= pull @ np.linalg.solve(drag, speeds @ z)
    rate = base.a @ z
    for k in range(len(resting)):
        if not resting[k]:
            rate += base.friction[:, k] * state[k]
    _, bound = friction_at_rest(speeds @ rate, -drag)
    for r in range(m):
        state[at_rest[r]] = np.int64(bound[r])
