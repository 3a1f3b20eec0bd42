"""Work over one span of a trajectory: the state carried on, and the powers integrated as exactly as it is."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import integrate
from scipy.linalg import expm

from symdyn.numeric.hybrid.exponential import growth_rate, legendre
from symdyn.numeric.hybrid.linear_mode import linear_mode
from symdyn.numeric.hybrid.machine import FRICTION, Machine
from symdyn.numeric.hybrid.signals import Signal, exosystem
from symdyn.numeric.hybrid.spans import Span, mode_of

Array = NDArray[np.float64]
Worker = Callable[[Array, Span], tuple[Array, Array]]

POWERS = ("supplied_power", "dissipated_power")
NODES, WEIGHTS = legendre(8)
REACH = 2.0  # of a part, over the machine's fastest time: 8 points then leave 1e-13 of a product of two exponentials
MOST_PARTS = 4096  # that are kept in memory at once
CLOSE = 1e-11  # relative tolerance where nothing is affine


def worker(machine: Machine, signals: Sequence[Signal]) -> Worker:
    """A function of x (nx,) at the start of a span, and the span: x at its end, and (P,) supplied, then dissipated."""
    return _affine(machine, signals) if machine.affine else _general(machine, signals)


def _affine(machine: Machine, signals: Sequence[Signal]) -> Worker:
    """The state at Gauss-Legendre points from exponentials; powers are quadratic in it, and so integrated exactly."""
    nx = len(machine.kernel.states)
    matrices: dict[tuple[object, ...], Array] = {}

    def work(x: Array, span: Span) -> tuple[Array, Array]:
        system, output, w = exosystem([signal.piece_at(span.begun) for signal in signals], span.first)
        s = mode_of(span.switches)
        key = (span.switches, system.tobytes(), output.tobytes())
        if key not in matrices:
            matrices[key] = linear_mode(machine, span.switches, system, output).a
        a = matrices[key]
        z = np.zeros(len(a))
        z[:nx], z[nx : nx + len(w)], z[-1] = x, w, 1.0
        length = span.last - span.first
        parts = max(1, math.ceil(length * growth_rate(a) / REACH))
        h = length / parts
        over, points = expm(a * h).T, [expm(a * (h * c)).T for c in NODES]
        total = 0.0
        for first in range(0, parts, MOST_PARTS):
            starts = _powers(over, z, min(MOST_PARTS, parts - first))
            z = starts[-1] @ over
            for point, weight in zip(points, WEIGHTS, strict=True):
                there = starts @ point
                inputs = there[:, nx : nx + len(w)] @ output.T
                total += h * weight * _all_powers(machine, there[:, :nx], inputs, s).sum(axis=0)
        return z[:nx], np.asarray(total)

    return work


def _powers(over: Array, z: Array, count: int) -> Array:
    """(count, n): z, z over, z over^2, ... by doubling."""
    rows = np.empty((count, len(z)))
    rows[0], made = z, 1
    while made < count:
        more = min(made, count - made)
        rows[made : made + more] = rows[:more] @ over
        over, made = over @ over, made + more
    return rows


def _all_powers(machine: Machine, x: Array, u: Array, s: Array) -> Array:
    x, u, modes = np.ascontiguousarray(x), np.ascontiguousarray(u), np.tile(s, (len(x), 1))
    return np.hstack([machine.rows(name, x, u, modes) for name in POWERS])


def _general(machine: Machine, signals: Sequence[Signal]) -> Worker:
    """The equations of the mode and the powers together, by Dormand and Prince's method of order 8."""
    module = machine.kernel.module
    nx, nf = len(machine.kernel.states), machine.count(FRICTION)
    spare = np.zeros(2 * nf + 2, np.int64), np.zeros((nx, nf)), np.zeros(2 * nf), np.zeros((nf, 2 * nf))

    def work(x: Array, span: Span) -> tuple[Array, Array]:
        s, switches = mode_of(span.switches), np.array(span.switches, dtype=np.int64)
        pieces = [signal.piece_at(span.begun) for signal in signals]
        jacobian = machine.call("guards_state_jacobian", x, np.zeros(len(pieces)), s).reshape(-1, nx)
        levers = np.ascontiguousarray(jacobian[:nf])
        sticks, friction, share, matrix = spare

        def rates(t: float, y: Array) -> Array:
            state, u = np.ascontiguousarray(y[:nx]), np.array([piece.at(np.array(t)) for piece in pieces], np.float64)
            out = np.zeros(nx)
            module._rate(state, u, s, switches, levers, sticks, friction, share, matrix, True, out)
            return np.concatenate([out, *(machine.call(name, state, u, s) for name in POWERS)])

        size = sum(len(machine.call(name, x, np.zeros(len(pieces)), s)) for name in POWERS)
        if span.last == span.first:
            return x, np.zeros(size)
        start = np.concatenate([x, np.zeros(size)])
        found = integrate.solve_ivp(
            rates, (span.first, span.last), start, method="DOP853", rtol=CLOSE, atol=CLOSE * 1e-3
        )
        end = found.y[:, -1]
        return np.array(end[:nx]), np.array(end[nx:])

    return work
