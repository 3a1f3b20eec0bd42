"""One mode of a piecewise-affine machine: its matrix with stuck friction solved, its guards, bounds on their growth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled
from symdyn.numeric.hybrid.exponential import expm1_levels, growth_rate
from symdyn.numeric.hybrid.fast_modes import fast_motions
from symdyn.numeric.hybrid.growth import largest_rows
from symdyn.numeric.hybrid.loops import absolute, copy, copy_row, transpose
from symdyn.numeric.hybrid.vectors import LANES, matrix_product, solve

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

ORDER = 4  # a guard and three derivatives at both ends of a step: a polynomial of degree 7
RADIX = 5
NO_ROOM, NOT_FINITE = -1, -2


class Base(NamedTuple):
    """The machine with the contacts and limits of one combination, in z = [x, signals, 1, 0 ...]; friction aside.

    d z/dt = a z + friction sigma, speeds z are the speeds that frictions oppose; gap z is the twist of
    each contact, high z and low z what its flanks press with when they are engaged; argument z is what
    each limit is applied to. ``gap_half`` and ``limits`` are the numbers they are compared with.
    Stacked, every array has a first axis more.
    """

    a: Array  # (n, n)
    friction: Array  # (n, nf)
    speeds: Array  # (nf, n)
    gap: Array  # (nc, n)
    high: Array  # (nc, n)
    low: Array  # (nc, n)
    argument: Array  # (nl, n)
    gap_half: Array  # (nc,)
    limits: Array  # (nl, 2)


class Modes(NamedTuple):
    """The modes met so far, with room for more; ``made[0]`` of them are made."""

    made: Ints  # (1,)
    one: int  # where z is 1
    codes: Ints  # (M,)
    step: Array  # (M, levels, n, n) exp - 1 of each halved step, transposed
    rows: Array  # (M, n, 4 G + 8 + n) guards, their first, second and third derivatives, w = [L; 1] dz/dt; transposed
    bounds: Array  # (M, 8 + n, G) of the eighth derivative, for |w|, transposed
    sizes: Array  # (M, n, G) |row|, for rounding, transposed
    sigma: Array  # (M, nf, n) friction as a share of its limit
    guards: Ints  # (M,) how many
    owner: Ints  # (M, G) the switch that each guard belongs to
    target: Ints  # (M, G) the state it then takes


@compiled
def room(modes: int, levels: int, n: int, one: int, frictions: int, guards: int) -> Modes:
    """Empty storage for so many modes; ``n`` and ``guards`` are multiples of eight."""
    return Modes(
        np.zeros(1, np.int64), one, np.full(modes, -1, np.int64), np.zeros((modes, levels, n, n)),
        np.zeros((modes, n, ORDER * guards + LANES + n)), np.zeros((modes, LANES + n, guards)),
        np.zeros((modes, n, guards)), np.zeros((modes, frictions, n)), np.zeros(modes, np.int64),
        np.zeros((modes, guards), np.int64), np.zeros((modes, guards), np.int64),
    )  # fmt: skip


@compiled
def code_of(state: Ints) -> int:
    """The states of all switches, each from -2 to 2, as one number."""
    code = 0
    for value in state:
        code = code * RADIX + value + 2
    return code


@compiled
def add_mode(modes: Modes, base: Base, state: Ints, horizon: float) -> int:
    """Make the mode of ``state`` (frictions, contacts, limits) and return its number.

    Or NO_ROOM or NOT_FINITE, where its matrix is not, both negative.
    """
    number = int(modes.made[0])
    if number == len(modes.codes):
        return NO_ROOM
    nf, nc, nl = len(base.speeds), len(base.gap), len(base.argument)
    n = len(base.a)
    one = modes.one
    sigma = modes.sigma[number]
    a = mode_matrix(base, state, sigma, one)
    rate = growth_rate(a)
    for i in range(n):
        for j in range(n):
            if not np.isfinite(a[i, j]):
                return NOT_FINITE
    if not np.isfinite(rate):
        return NOT_FINITE
    row, most = 0, modes.bounds.shape[2]
    guards = np.zeros((most, n))
    for g in range(most):
        guards[g, one] = 1.0  # what is not used is never crossed
    for k in range(nf):
        if state[k] == 0:
            for way in (1, -1):
                copy_row(sigma, k, -way, guards, row)
                guards[row, one] += 1.0
                row = _own(modes, number, row, k, way)
        else:
            copy_row(base.speeds, k, state[k], guards, row)
            row = _own(modes, number, row, k, 0)
    for c in range(nc):
        now, k = state[nf + c], nf + c
        if now == 0:
            for way in (1, -1):
                copy_row(base.gap, c, -way, guards, row)
                guards[row, one] += base.gap_half[c]
                row = _own(modes, number, row, k, way)
            continue
        way = 1 if now > 0 else -1
        press = base.high if way > 0 else base.low
        if abs(now) == 1:
            copy_row(press, c, 1, guards, row)
            row = _own(modes, number, row, k, 2 * way)
        else:
            copy_row(press, c, -1, guards, row)
            row = _own(modes, number, row, k, way)
            copy_row(base.gap, c, way, guards, row)
            guards[row, one] -= base.gap_half[c]
            row = _own(modes, number, row, k, 0)
    for m in range(nl):
        now, k = state[nf + nc + m], nf + nc + m
        if now <= 0:
            copy_row(base.argument, m, 1 if now == 0 else -1, guards, row)
            guards[row, one] -= base.limits[m, 0] * (1.0 if now == 0 else -1.0)
            row = _own(modes, number, row, k, -1 if now == 0 else 0)
        if now >= 0:
            copy_row(base.argument, m, -1 if now == 0 else 1, guards, row)
            guards[row, one] += base.limits[m, 1] * (1.0 if now == 0 else -1.0)
            row = _own(modes, number, row, k, 1 if now == 0 else 0)
    modes.guards[number] = row
    modes.codes[number] = code_of(state)
    turned = np.empty((n, n))
    transpose(a, turned, 0)
    expm1_levels(turned, rate, horizon, modes.step[number])
    rows = modes.rows[number]
    derived, following = np.empty((most, n)), np.empty((most, n))
    copy(guards, derived)
    transpose(absolute(guards), modes.sizes[number], 0)
    for order in range(2 * ORDER - 1):  # up to A^7: dz/dt brings the eighth
        if order < ORDER:
            transpose(derived, rows, order * most)
        matrix_product(derived, a, following)
        derived, following = following, derived
    right, left = fast_motions(a, horizon)
    transpose(largest_rows(derived, a, rate, horizon, right, left), modes.bounds[number], 0)
    fast = np.empty((LANES, n))
    matrix_product(left, a, fast)
    transpose(fast, rows, ORDER * most)
    transpose(a, rows, ORDER * most + LANES)
    modes.made[0] += 1
    return number


@compiled
def mode_matrix(base: Base, state: Ints, sigma: Array, one: int) -> Array:
    """(n, n) A of dz/dt = A z in the mode; entry ``one`` of z is 1.

    ``sigma`` (nf, n) is filled in with each friction's share of its limit.
    """
    nf, n = len(base.speeds), len(base.a)
    a = np.empty((n, n))
    copy(base.a, a)
    for k in range(nf):
        for i in range(sigma.shape[1]):
            sigma[k, i] = 0.0
        sigma[k, one] = state[k]
        for i in range(n):
            a[i, one] += base.friction[i, k] * state[k]
    stuck, many = np.empty(nf, np.int64), 0
    for k in range(nf):
        if state[k] == 0:
            stuck[many] = k
            many += 1
    if many:
        speeds = np.empty((many, n))
        pull = np.empty((n, many))
        for r in range(many):
            copy_row(base.speeds, stuck[r], 1, speeds, r)
            for i in range(n):
                pull[i, r] = base.friction[i, stuck[r]]
        share = _shares(speeds, pull, a)
        for r in range(many):
            copy_row(share, r, 1, sigma, stuck[r])
            for i in range(n):
                for j in range(n):
                    a[i, j] += pull[i, r] * share[r, j]
        for r in range(many):
            entry = only_entry(speeds[r])
            if entry >= 0:  # stays zero exactly: its row is nothing but rounding
                for j in range(n):
                    a[entry, j] = 0.0
    return a


@compiled
def _own(modes: Modes, number: int, row: int, switch: int, target: int) -> int:
    modes.owner[number, row] = switch
    modes.target[number, row] = target
    return row + 1


@compiled
def _shares(speeds: Array, pull: Array, a: Array) -> Array:
    """(m, n) of friction that keeps speeds z at zero: -(speeds pull)^-1 speeds a."""
    m, n = speeds.shape
    drag, share = np.zeros((m, m)), np.empty((m, n))
    matrix_product(speeds, a, share)
    for r in range(m):
        for c in range(m):
            for i in range(n):
                drag[r, c] -= speeds[r, i] * pull[i, c]
    solve(drag, share, m)
    return share


@compiled
def only_entry(speed: Array) -> int:
    """The state that a speed is by itself, or -1."""
    entry = -1
    for i in range(len(speed)):
        if speed[i] != 0.0:
            if entry >= 0:
                return -1
            entry = i
    return entry
