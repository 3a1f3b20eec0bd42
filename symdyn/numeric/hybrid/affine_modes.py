"""One mode of a piecewise-affine machine: its matrix with stuck friction solved, its guards, bounds on their growth."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled
from symdyn.numeric.hybrid.exponential import expm1_levels, largest_rows

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

ORDER = 4  # a guard and three derivatives at both ends of a step: a polynomial of degree 7
RADIX = 5


class Base(NamedTuple):
    """The machine with the contacts and limits of one combination, in z = [x, signals, 1], (n,); friction aside.

    d z/dt = a z + friction sigma, speeds z are the speeds that frictions oppose; gap z is the twist of
    each contact, high z and low z what its flanks press with when they are engaged; argument z is what
    each limit is applied to. ``gap_half`` and ``limits`` are the numbers they are compared with.
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

    made: Ints
    codes: Ints  # (M,)
    step: Array  # (M, levels, n, n) exp - 1 of each halved step, transposed
    rows: Array  # (M, n, 4 G + n) guards, their first, second and third derivatives, dz/dt; transposed
    bounds: Array  # (M, n, G) of the eighth derivative, for |dz/dt|, transposed
    sizes: Array  # (M, n, G) |row|, for rounding, transposed
    sigma: Array  # (M, nf, n) friction as a share of its limit
    guards: Ints  # (M,) how many
    owner: Ints  # (M, G) the switch that each guard belongs to
    target: Ints  # (M, G) the state it then takes


def room(modes: int, levels: int, n: int, frictions: int, guards: int) -> Modes:
    """Empty storage for so many modes."""
    return Modes(
        np.zeros(1, np.int64), np.full(modes, -1, np.int64), np.zeros((modes, levels, n, n)),
        np.zeros((modes, n, ORDER * guards + n)), np.zeros((modes, n, guards)), np.zeros((modes, n, guards)),
        np.zeros((modes, frictions, n)), np.zeros(modes, np.int64), np.zeros((modes, guards), np.int64),
        np.zeros((modes, guards), np.int64),
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
    """Make the mode of ``state`` (frictions, contacts, limits) and return its number, or -1 without room."""
    number = int(modes.made[0])
    if number == len(modes.codes):
        return -1
    nf, nc, nl = len(base.speeds), len(base.gap), len(base.argument)
    n = len(base.a)
    one = n - 1
    sigma = modes.sigma[number]
    a = mode_matrix(base, state, sigma)
    row, most = 0, modes.bounds.shape[2]
    guards = np.zeros((most, n))
    guards[:, one] = 1.0  # what is not used is never crossed
    for k in range(nf):
        if state[k] == 0:
            for way in (1, -1):
                guards[row] = -way * sigma[k]
                guards[row, one] += 1.0
                row = _own(modes, number, row, k, way)
        else:
            guards[row] = state[k] * base.speeds[k]
            row = _own(modes, number, row, k, 0)
    for c in range(nc):
        now, k = state[nf + c], nf + c
        if now == 0:
            for way in (1, -1):
                guards[row] = -way * base.gap[c]
                guards[row, one] += base.gap_half[c]
                row = _own(modes, number, row, k, way)
            continue
        way = 1 if now > 0 else -1
        press = base.high[c] if way > 0 else base.low[c]
        if abs(now) == 1:
            guards[row] = press
            row = _own(modes, number, row, k, 2 * way)
        else:
            guards[row] = -press
            row = _own(modes, number, row, k, way)
            guards[row] = way * base.gap[c]
            guards[row, one] -= base.gap_half[c]
            row = _own(modes, number, row, k, 0)
    for m in range(nl):
        now, k = state[nf + nc + m], nf + nc + m
        if now <= 0:
            guards[row] = base.argument[m] * (1.0 if now == 0 else -1.0)
            guards[row, one] -= base.limits[m, 0] * (1.0 if now == 0 else -1.0)
            row = _own(modes, number, row, k, -1 if now == 0 else 0)
        if now >= 0:
            guards[row] = base.argument[m] * (-1.0 if now == 0 else 1.0)
            guards[row, one] += base.limits[m, 1] * (1.0 if now == 0 else -1.0)
            row = _own(modes, number, row, k, 1 if now == 0 else 0)
    modes.guards[number] = row
    modes.codes[number] = code_of(state)
    expm1_levels(a, horizon, modes.step[number])
    derived = guards.copy()
    for order in range(ORDER):
        modes.rows[number, :, order * most : (order + 1) * most] = derived.T
        derived = derived @ a
    for _ in range(ORDER - 1):  # up to A^7: dz/dt brings the eighth
        derived = derived @ a
    modes.bounds[number] = largest_rows(derived, a, horizon).T
    modes.sizes[number] = np.abs(guards).T
    modes.rows[number, :, ORDER * most :] = a.T
    modes.made[0] += 1
    return number


@compiled
def mode_matrix(base: Base, state: Ints, sigma: Array) -> Array:
    """(n, n) A of dz/dt = A z in the mode; ``sigma`` (nf, n) is filled in with each friction's share of its limit."""
    nf, n = len(base.speeds), len(base.a)
    one = n - 1
    a = base.a.copy()
    for k in range(nf):
        sigma[k] = 0.0
        sigma[k, one] = state[k]
        for i in range(n):
            a[i, one] += base.friction[i, k] * state[k]
    stuck = np.array([k for k in range(nf) if state[k] == 0], np.int64)
    if len(stuck):
        speeds = np.empty((len(stuck), n))
        pull = np.empty((n, len(stuck)))
        for r, k in enumerate(stuck):
            speeds[r] = base.speeds[k]
            pull[:, r] = base.friction[:, k]
        share = -np.linalg.solve(speeds @ pull, speeds @ a)
        a += pull @ share
        for r, k in enumerate(stuck):
            sigma[k] = share[r]
            _stop(a, speeds[r])
    return a


@compiled
def _own(modes: Modes, number: int, row: int, switch: int, target: int) -> int:
    modes.owner[number, row] = switch
    modes.target[number, row] = target
    return row + 1


@compiled
def _stop(a: Array, speed: Array) -> None:
    """A speed that is a state by itself stays zero exactly: its row is nothing but rounding."""
    entry = -1
    for i in range(len(speed)):
        if speed[i] != 0.0:
            if entry >= 0:
                return
            entry = i
    a[entry] = 0.0
