"""Hidden states driven by the measured motion: friction that remembers needs no guess of what it was."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel

Array = NDArray[np.float64]

NUDGE = 1e-7  # of a state, for the slope of its rate


def remembered(kernel: Kernel, q: Array, qd: Array, time: Array, segments: tuple[slice, ...], p: Array) -> Array:
    """(N, n) effort that the hidden states exert at the joints along a motion q, qd (N, n).

    The kernel's own rates are integrated from sample to sample with the motion halfway between them, by
    the exponential Euler rule: exact where a rate is linear in its state, and stable however fast
    it is. Every segment begins from zero.
    """
    states = np.zeros((len(time), len(kernel.states)))
    n = q.shape[1]
    states[:, :n], states[:, n : 2 * n] = q, qd
    inputs = np.zeros((len(time), len(kernel.inputs)))
    for part in segments:
        _advance(kernel.state_derivative_p_into, states[part], inputs[0], np.ascontiguousarray(time[part]), p, 2 * n)
    return np.asarray(kernel.actuation_p_batch(states, inputs, p))


@njit(error_model="numpy")  # type: ignore[untyped-decorator]  # not cached: its type names the module of one kernel
def _advance(rate: Any, states: Array, control: Array, time: Array, p: Array, first: int) -> None:
    """Fill the hidden part of ``states`` (N, nx), columns ``first`` and on, in place."""
    count, size = states.shape
    x, plain, nudged = np.empty(size), np.empty(size), np.empty(size)
    for k in range(count - 1):
        step = time[k + 1] - time[k]
        for i in range(first):
            x[i] = 0.5 * (states[k, i] + states[k + 1, i])
        for i in range(first, size):
            x[i] = states[k, i]
        rate(x, control, p, plain)
        for i in range(first, size):
            x[i] += NUDGE * (1.0 + abs(states[k, i]))
        rate(x, control, p, nudged)
        for i in range(first, size):
            slope = step * (nudged[i] - plain[i]) / (NUDGE * (1.0 + abs(states[k, i])))
            share = 1.0 + 0.5 * slope if abs(slope) < 1e-5 else np.expm1(min(slope, 50.0)) / slope
            states[k + 1, i] = states[k, i] + step * plain[i] * share
