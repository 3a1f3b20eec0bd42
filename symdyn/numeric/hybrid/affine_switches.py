"""Which mode a piecewise-affine machine is in: at the start, and after guards have been crossed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid import affine_modes
from symdyn.numeric.hybrid.affine_modes import ORDER, Base, Modes, add_mode, code_of, only_entry
from symdyn.numeric.hybrid.compiled import compiled, inlined
from symdyn.numeric.hybrid.friction_modes import friction_at_rest
from symdyn.numeric.hybrid.trajectory import CHATTERS, DONE, NEED_BASE, NO_ROOM, NOT_FINITE, TOO_MANY
from symdyn.numeric.hybrid.vectors import solve, times, times_sizes

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

ROUNDING = 1e-14
SAME_INSTANT = 64  # switches at one instant before it is called chattering


# Places in the tally of a propagation: counts; where to go on, with which level of steps; the base it needs.
EVENTS, STEPS, TRIES, STEP, TICK, LEVEL, BASE = TALLY = tuple(range(7))


@compiled
def find(modes: Modes, code: int) -> int:
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
def pick(bases: Base, number: int) -> Base:
    """One of stacked bases."""
    return Base(
        bases.a[number], bases.friction[number], bases.speeds[number], bases.gap[number], bases.high[number],
        bases.low[number], bases.argument[number], bases.gap_half[number], bases.limits[number],
    )  # fmt: skip


@compiled
def place_of(known: Ints, number: int) -> int:
    """Where the base of a combination is in the stack, or -1; ``known`` are the numbers there."""
    for k in range(len(known)):
        if known[k] == number:
            return k
    return -1


@compiled
def begin(z: Array, state: Ints, bases: Base, known: Ints, tally: Ints) -> int:
    """Set ``state`` to what holds at ``z``: at the start, and after a jump of the inputs. Returns DONE or NEED_BASE."""
    nf, nc = bases.speeds.shape[1], bases.gap.shape[1]
    base = pick(bases, 0)
    for _ in range(2 * len(state) + 1):  # what is limited may depend on other limits
        number = base_of(state, nf, nc)
        place = place_of(known, number)
        if place < 0:
            tally[BASE] = number
            return NEED_BASE
        base = pick(bases, place)
        changed = False
        for k in range(nf, len(state)):
            now = _held(z, base, k - nf, k - nf - nc)
            changed = changed or now != state[k]
            state[k] = now
        if not changed:
            break
    resting = np.zeros(nf, np.bool_)
    for k in range(nf):
        speed = _dot(base.speeds[k], z)
        resting[k] = speed == 0.0
        state[k] = np.int64(np.sign(speed))
    _settle(z, state, base, resting)
    return DONE


@compiled
def _held(z: Array, base: Base, contact: int, limit: int) -> int:
    """The state of a contact, or of a limit where ``limit`` is not negative."""
    if limit >= 0:
        value = _dot(base.argument[limit], z)
        return 1 if value > base.limits[limit, 1] else (-1 if value < base.limits[limit, 0] else 0)
    twist = _dot(base.gap[contact], z)
    if abs(twist) <= base.gap_half[contact]:
        return 0
    press = _dot(base.high[contact] if twist > 0.0 else base.low[contact], z)
    return (1 if twist > 0.0 else -1) * (1 if press > 0.0 else 2)


@compiled
def _dot(row: Array, z: Array) -> float:
    total = 0.0
    for i in range(len(z)):
        total += row[i] * z[i]
    return total


@compiled
def enter(state: Ints, bases: Base, known: Ints, modes: Modes, horizon: float, tally: Ints) -> int:
    """See that the mode of ``state`` is made."""
    if find(modes, code_of(state)) >= 0:
        return DONE
    number = base_of(state, bases.speeds.shape[1], bases.gap.shape[1])
    place = place_of(known, number)
    if place < 0:
        tally[BASE] = number
        return NEED_BASE
    made = add_mode(modes, pick(bases, place), state, horizon)
    if made >= 0:
        return DONE
    return NO_ROOM if made == affine_modes.NO_ROOM else NOT_FINITE


@inlined
def evaluate(modes: Modes, mode: int, columns: int, z: Array, at: int, values: Array, to: int) -> None:
    """From ``to`` on, values = [guards, their first, second and third derivatives, dz/dt] at z[at:]."""
    n, width = modes.rows.shape[1:]
    times(modes.rows, mode * n * width, width, z, at, columns, values, to)


@inlined
def round_off(modes: Modes, mode: int, columns: int, z: Array, at: int, rounding: Array) -> None:
    """What rounding may make of each guard at z[at:]."""
    n, count = modes.sizes.shape[1:]
    times_sizes(modes.sizes, mode * n * count, count, z, at, columns, rounding, 0)
    for g in range(count):
        rounding[g] *= ROUNDING


@compiled
def switch(
    z: Array, state: Ints, bases: Base, known: Ints, modes: Modes, horizon: float, mode: int, columns: int,
    values: Array, rounding: Array, resting: Flags, before: Ints, events: Array, tally: Ints, time: float
) -> int:  # fmt: skip
    """Change the switches whose guards have been crossed, until all guards of the mode that results hold.

    ``values`` and ``rounding`` are those of the mode, and of the new one afterwards. An empty ``events`` only counts.
    """
    nf, nc = bases.speeds.shape[1], bases.gap.shape[1]
    rest = False
    for k in range(nf):
        resting[k] = state[k] == 0  # frictions whose speed is zero now
        rest = rest or resting[k]
    _copy(state, before)
    for turn in range(SAME_INSTANT):
        crossed = False
        for g in range(modes.guards[mode]):
            k = modes.owner[mode, g]
            if _violated(values, rounding, g, turn == 0):
                crossed = True
                if k < nf:
                    resting[k] = rest = True
                else:
                    state[k] = modes.target[mode, g]
        if not crossed and turn > 0:
            break
        if rest:
            number = base_of(state, nf, nc)
            place = place_of(known, number)
            if place < 0:
                _copy(before, state)
                tally[BASE] = number
                return NEED_BASE
            _settle(z, state, pick(bases, place), resting)
        status = enter(state, bases, known, modes, horizon, tally)
        if status != DONE:
            _copy(before, state)
            return status
        mode = find(modes, code_of(state))
        evaluate(modes, mode, columns, z, 0, values, 0)
        round_off(modes, mode, columns, z, 0, rounding)
    else:
        return CHATTERS
    for k in range(len(state)):
        if state[k] != before[k]:
            if len(events) > 0:
                if tally[EVENTS] == len(events):
                    return TOO_MANY
                events[tally[EVENTS], 0] = time
                events[tally[EVENTS], 1] = k
                events[tally[EVENTS], 2] = before[k]
                events[tally[EVENTS], 3] = state[k]
            tally[EVENTS] += 1
    return DONE


@compiled
def _copy(states: Ints, out: Ints) -> None:
    for k in range(len(states)):
        out[k] = states[k]


@compiled
def _violated(values: Array, rounding: Array, g: int, arriving: bool) -> bool:
    """Whether a guard is negative, or zero and about to be (not for one that has just been reached)."""
    count = len(rounding)
    if values[g] < -rounding[g]:
        return True
    if arriving or values[g] > rounding[g]:
        return False
    for order in range(1, ORDER):
        rate = values[order * count + g]
        if rate != 0.0:
            return bool(rate < 0.0)
    return False


@compiled
def _settle(z: Array, state: Ints, base: Base, resting: Flags) -> None:
    """Put speeds that have come to zero there exactly, and decide who sticks and who sets off which way."""
    count, last = 0, -1
    for k in range(len(resting)):
        if resting[k]:
            count, last = count + 1, k
    if count == 1:
        _settle_one(z, state, base, resting, last)
    elif count > 1:
        _settle_together(z, state, base, resting, count)


@compiled
def _settle_one(z: Array, state: Ints, base: Base, resting: Flags, k: int) -> None:
    """Friction ``k`` alone is at rest.

    If it could hold all but a rounding error, it holds: else its body would creep by that, and no step of it could be
    proven. The margin is within what the guard of what sticks is allowed, which is a share of 1 and more.
    """
    speed = base.speeds[k]
    drag = 0.0
    for i in range(len(z)):
        drag += speed[i] * base.friction[i, k]
    moving = _dot(speed, z) / drag
    for i in range(len(z)):
        z[i] -= base.friction[i, k] * moving
    _stop(z, speed)
    share = -_unhindered(z, state, base, resting, k) / drag
    state[k] = np.int64(np.sign(share)) if abs(share) > 1.0 + 0.5 * ROUNDING else 0


@compiled
def _settle_together(z: Array, state: Ints, base: Base, resting: Flags, m: int) -> None:
    """The same for ``m`` frictions, which act on one another."""
    at_rest = np.flatnonzero(resting)
    drag, moving, free = np.zeros((m, m)), np.zeros((m, 1)), np.zeros(m)
    for r in range(m):
        speed = base.speeds[at_rest[r]]
        moving[r, 0] = _dot(speed, z)
        for c in range(m):
            for i in range(len(z)):
                drag[r, c] += speed[i] * base.friction[i, at_rest[c]]
    solve(drag.copy(), moving, m)
    for r in range(m):
        for i in range(len(z)):
            z[i] -= base.friction[i, at_rest[r]] * moving[r, 0]
    for r in range(m):
        _stop(z, base.speeds[at_rest[r]])
        free[r] = _unhindered(z, state, base, resting, at_rest[r])
    _, bound = friction_at_rest(free, -drag)
    for r in range(m):
        state[at_rest[r]] = np.int64(bound[r])


@compiled
def _stop(z: Array, speed: Array) -> None:
    """A speed that is a state by itself is zero to the last bit."""
    entry = only_entry(speed)
    if entry >= 0:
        z[entry] = 0.0


@compiled
def _unhindered(z: Array, state: Ints, base: Base, resting: Flags, friction: int) -> float:
    """The rate of a speed at rest, without the frictions that are at rest."""
    speed, total = base.speeds[friction], 0.0
    for i in range(len(z)):
        if speed[i] != 0.0:
            rate = _dot(base.a[i], z)
            for k in range(len(resting)):
                if not resting[k]:
                    rate += base.friction[i, k] * state[k]
            total += speed[i] * rate
    return total
