"""Hidden states that act on one another, driven along a motion: an inertia behind a spring goes on swinging."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel
from symdyn.numeric.transition import HALVES, room, transition

Array = NDArray[np.float64]

NUDGE = 1e-7  # of a state, for the slope of its rate
SAME = 1e-6  # relative change of a slope, or of a step, below which it is the nudge's

VECTOR, MATRIX = (types.Array(types.float64, d, "C") for d in (1, 2))
RATE = types.FunctionType(types.none(VECTOR, VECTOR, VECTOR, VECTOR))  # any kernel's: so it is compiled once


def swings(kernel: Kernel, p: Array) -> bool:
    """Whether it has hidden states that act on one another: how they began shows for long."""
    n, count = len(kernel.coordinates), len(kernel.states)
    if count < 2 * n + 2:
        return False
    rate, inputs = kernel.hidden_state_derivative_p_into, np.zeros(len(kernel.inputs))
    return bool(np.any(coupled(rate, np.zeros(count), inputs, np.array(p), 2 * n)))


def started(kernel: Kernel, time: Array, segments: tuple[slice, ...], p: Array) -> Array:
    """(N, n, m) effort that hidden states which act on one another exert at joints that stand.

    One column for each of them and each segment, at whose beginning it is one. How they began is in no recording, and
    what swings goes on for long.
    """
    n, count = len(kernel.coordinates), len(kernel.states)
    rate, inputs, own = kernel.hidden_state_derivative_p_into, np.zeros((len(time), len(kernel.inputs))), np.array(p)
    swinging = 2 * n + np.flatnonzero(coupled(rate, np.zeros(count), inputs[0], own, 2 * n))
    found = []
    for part in segments:
        for i in swinging:
            states = np.zeros((len(time), count))
            states[part.start, i] = 1.0
            advance_together(rate, states[part], inputs[0], np.array(time[part]), own, 2 * n)
            found.append(kernel.rows("actuation_p", states, inputs, p))
    return np.stack(found, axis=2)


@njit(types.void(RATE, VECTOR, VECTOR, VECTOR, VECTOR, MATRIX), cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _jacobian(rate: Any, x: Array, control: Array, p: Array, plain: Array, slopes: Array) -> None:
    """Rates ``plain`` (h,) of the last h entries of ``x``, and their ``slopes`` (h, h) by these, in place."""
    hidden = len(plain)
    first, nudged = len(x) - hidden, np.empty(hidden)
    rate(x, control, p, plain)
    for j in range(hidden):
        known = x[first + j]
        nudge = NUDGE * (1.0 + abs(known))
        x[first + j] = known + nudge
        rate(x, control, p, nudged)
        x[first + j] = known
        for i in range(hidden):
            slopes[i, j] = (nudged[i] - plain[i]) / nudge


def coupled(rate: Any, x: Array, control: Array, p: Array, first: int) -> NDArray[np.bool_]:
    """(h,) Which hidden states act on another one, or another on them."""
    hidden = len(x) - first
    slopes = np.zeros((hidden, hidden))
    _jacobian(rate, np.array(x), control, p, np.zeros(hidden), slopes)
    return _off_diagonal(slopes)


def _off_diagonal(slopes: Array) -> NDArray[np.bool_]:
    across = slopes - np.diag(np.diag(slopes))
    return np.asarray(np.any(across, axis=0) | np.any(across, axis=1))


def settle(rate: Any, state: Array, control: Array, p: Array, first: int) -> None:
    """Hidden states that act on one another where their rates vanish, in place."""
    hidden = len(state) - first
    plain, slopes = np.zeros(hidden), np.zeros((hidden, hidden))
    _jacobian(rate, np.array(state), control, p, plain, slopes)
    alone = ~_off_diagonal(slopes)
    slopes[alone], plain[alone] = np.eye(hidden)[alone], 0.0
    state[first:] -= np.linalg.solve(slopes, plain)


@njit(  # type: ignore[untyped-decorator]
    types.void(RATE, MATRIX, VECTOR, VECTOR, VECTOR, types.int64), cache=True, error_model="numpy"
)
def advance_together(rate: Any, states: Array, control: Array, time: Array, p: Array, first: int) -> None:
    """Fill columns from ``first`` on of ``states`` (N, nx), in place: z + h phi1(h J) f + h phi2(h J) (f' - f).

    Rates go straight from f, with the motion at a sample, to f', with that at the next. Integral and ramp of
    ``transition``, h phi1 and h^2 phi2, are computed anew where the slopes changed: those of what swings freely do not.
    """
    count, size = states.shape
    hidden = size - first
    x, plain, slopes = np.empty(size), np.empty(hidden), np.empty((hidden, hidden))
    before, after = np.empty(hidden), np.empty(hidden)
    spent, wide = 0.0, room(hidden)
    jacobian, term, work = np.zeros((wide, wide)), np.zeros((wide, wide)), np.zeros((wide, wide))
    ladder = np.zeros((HALVES + 1, 3, wide, wide))
    integral, ramp = ladder[0, 1], ladder[0, 2]
    for k in range(count - 1):
        step = time[k + 1] - time[k]
        for i in range(first):
            x[i] = 0.5 * (states[k, i] + states[k + 1, i])
        for i in range(first, size):
            x[i] = states[k, i]
        _jacobian(rate, x, control, p, plain, slopes)
        changed = k == 0 or abs(step - spent) > SAME * step
        for i in range(hidden):
            for j in range(hidden):
                changed = changed or not abs(slopes[i, j] - jacobian[i, j]) <= SAME * (1.0 + abs(slopes[i, j]))
        if changed:
            spent = step
            for i in range(hidden):
                for j in range(hidden):
                    jacobian[i, j] = slopes[i, j]
            transition(jacobian, hidden, step, True, ladder, term, work)
        for i in range(first):
            x[i] = states[k, i]
        rate(x, control, p, before)
        for i in range(first):
            x[i] = states[k + 1, i]
        rate(x, control, p, after)
        for i in range(hidden):
            moved = 0.0
            for j in range(hidden):
                moved += integral[i, j] * before[j] + ramp[i, j] / step * (after[j] - before[j])
            states[k + 1, first + i] = states[k, first + i] + moved
