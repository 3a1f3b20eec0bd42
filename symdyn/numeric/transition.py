"""One step of a machine between two samples: the exponential of its Jacobian, and the integral of that."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled
from symdyn.numeric.hybrid.loops import copy
from symdyn.numeric.hybrid.vectors import LANES, times

Array = NDArray[np.float64]

TERMS = 12  # of the series at the shortest step, at most
EXACT = 1e-10  # of it: its last term
SWEEPS = 2  # of balancing
TINY = 1e-3
HALVES = 12  # of a step, at most
SHORT = 0.8  # largest row sum of A h at the shortest step


@compiled
def room(count: int) -> int:
    """The next multiple of what ``product`` multiplies at once."""
    return -(-count // LANES) * LANES


@compiled
def product(a: Array, b: Array, rows: int, inner: int, out: Array) -> None:
    """out[:rows] = a[:rows, :inner] b[:inner]; all of them with room, and where ``inner`` is odd b[inner] is zero."""
    across = b.shape[1]
    for i in range(rows):
        times(b, 0, across, a, i * a.shape[1], inner + inner % 2, out, i * across)


@compiled
def balanced_norm(a: Array, n: int) -> float:
    """Largest row sum of |D A D^-1|, D diagonal and chosen to make it small (Osborne 1960): free of units.

    The series of exp(A) is as good as that of the balanced matrix, entry by entry.
    """
    d = np.empty(n)
    for i in range(n):
        d[i] = 1.0
    for _ in range(SWEEPS):
        for i in range(n):
            row, column = 0.0, 0.0
            for j in range(n):
                if j != i:
                    row += abs(a[i, j]) * d[j]
                    column += abs(a[j, i]) / d[j]
            if row > 0.0 and column > 0.0:
                d[i] = np.sqrt(row / column)
            elif column > 0.0:  # what nothing changes may be as large as it likes
                d[i] *= TINY
    largest = 0.0
    for i in range(n):
        row = 0.0
        for j in range(n):
            row += abs(a[i, j]) * d[j] / d[i]
        largest = max(largest, row)
    return largest


@compiled
def double(of: Array, out: Array, n: int, ramped: bool) -> None:
    """``out`` (3, n, n) gets those of a step twice as long as that of ``of``; as ``transition`` gives them."""
    for part in range(3 if ramped else 2):
        product(of[1 if part == 2 else 0], of[0 if part == 0 else 1], n, n, out[part])
        for i in range(n):
            for j in range(out.shape[2]):
                out[part, i, j] += 2.0 * of[part, i, j]


@compiled
def transition(a: Array, n: int, step: float, ramped: bool, ladder: Array, term: Array, work: Array) -> int:
    """exp(A h) - 1, the integral of exp(A t) over 0..h, and ramp, the integral of that, of h = ``step`` in ladder[0].

    A constant source c adds integral c to the state, one that grows as c t / h adds ramp c / h. By series and doubling.
    ``ladder`` (HALVES + 1 or more, 3, n, n) gets the same three for h / 2, h / 4, ..., and what is returned is how many
    of them: a stiff machine's first moments. Ramps only where ``ramped``; ``term`` and ``work`` are for use here. All
    matrices with room.
    """
    largest = balanced_norm(a, n)
    doublings = 0
    while largest * step * 0.5**doublings > SHORT and doublings < 60:
        doublings += 1
    h = step * 0.5**doublings
    many = min(doublings, HALVES)
    shortest = ladder[many]
    count = n * a.shape[1]
    flat_integral, flat_ramp = shortest[1].ravel(), shortest[2].ravel()  # views
    flat_term, flat_work = term.ravel(), work.ravel()
    for i in range(count):
        flat_term[i] = flat_integral[i] = flat_ramp[i] = 0.0
    for i in range(n):
        term[i, i] = shortest[1, i, i] = h
        shortest[2, i, i] = 0.5 * h * h
    last, size = 1.0, largest * h
    for k in range(2, TERMS + 1):
        last *= size / k
        if last < EXACT:
            break
        product(a, term, n, n, work)
        for i in range(count):
            flat_term[i] = flat_work[i] * (h / k)
            flat_integral[i] += flat_term[i]
        if ramped:
            for i in range(count):
                flat_ramp[i] += flat_term[i] * (h / (k + 1))
    product(a, shortest[1], n, n, shortest[0])
    for _ in range(doublings - many):  # shorter ones than there is room for
        double(shortest, ladder[many - 1], n, ramped)
        for part in range(3):
            copy(ladder[many - 1, part], shortest[part])
    for level in range(many, 0, -1):
        double(ladder[level], ladder[level - 1], n, ramped)
    return many


@compiled
def source_weights(
    ladder: Array, many: int, n: int, h: float, nodes: Array, rest: Array, term: Array, work: Array
) -> None:
    """What a source of the rate adds to n states over a step of ``h``: the sum of nodes[i] times the source at each of
    the moments 0, h / 2^many, ..., h / 2, h, between which it goes straight.

    ``ladder`` is that of ``transition``, or begins at a level of it; ``nodes`` (many + 2 or more, n, n) with room,
    ``rest``, ``term`` and ``work`` for use here.
    """
    for i in range(n):
        for j in range(rest.shape[1]):
            rest[i, j] = 1.0 if i == j else 0.0  # from the end of a piece to that of the step
            nodes[many + 1, i, j] = term[i, j] = 0.0
    for piece in range(many, -1, -1):
        level = many - piece + 1 if piece else many
        per_length = 2.0**level / h
        for i in range(n):
            for j in range(n):
                term[i, j] = per_length * ladder[level, 2, i, j]
        product(rest, term, n, n, work)
        for i in range(n):
            for j in range(n):
                nodes[piece + 1, i, j] += work[i, j]
                term[i, j] = ladder[level, 1, i, j] - term[i, j]
        product(rest, term, n, n, nodes[piece])
        if piece:
            for i in range(n):
                for j in range(n):
                    term[i, j] = ladder[level, 0, i, j] + (1.0 if i == j else 0.0)
            product(rest, term, n, n, work)
            copy(work, rest)
