"""Hidden states driven by the measured motion: friction that remembers needs no guess of what it was."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from symdyn.base import symbols
from symdyn.emit.kernel import Kernel
from symdyn.numeric.swinging import MATRIX, NUDGE, RATE, VECTOR, advance_together, coupled, settle
from symdyn.physics import catalogue
from symdyn.physics.effect import MOVING, Effect, Values
from symdyn.spec.places import places
from symdyn.spec.records import Robot

Array = NDArray[np.float64]


def driven_states(robot: Robot) -> frozenset[str]:
    """Hidden states that follow from the motion of the joints alone: those of friction that remembers."""
    found = []
    for effect in robot.effects:
        law = catalogue()[effect.type]
        moving = next(p.kind for p in places(robot) if p.address == effect.at) in MOVING
        if not moving or law.input_unit() is not None or law.reference_unit() is not None:
            continue
        found += [f"{effect.at}.{state.name}" for state in law.hidden_states(_symbols(law))]
    return frozenset(found)


def _symbols(law: Effect) -> Values:
    return {schema.name: symbols.local(schema.name) for schema in law.parameters}


def remembered(
    kernel: Kernel,
    q: Array,
    qd: Array,
    time: Array,
    segments: tuple[slice, ...],
    p: Array,
    together: bool | None = None,
) -> Array:
    """(N, n) effort that the hidden states exert at the joints along a motion q, qd (N, n).

    The kernel's own rates are integrated from sample to sample with the motion halfway between them, by
    the exponential Euler rule: exact where a rate is linear in its state, and stable however fast
    it is. Every segment begins from zero; states that act on one another (an elastic load) begin where their rates
    vanish: in step with the motion. ``together`` says whether these do (None: that is found out).
    """
    states = np.zeros((len(time), len(kernel.states)))
    n = q.shape[1]
    states[:, :n], states[:, n : 2 * n] = q, qd
    inputs = np.zeros((len(time), len(kernel.inputs)))
    rate, own = kernel.hidden_state_derivative_p_into, np.array(p)  # copies: compiled code wants what it could write to
    if together is None:
        together = bool(np.any(coupled(rate, states[0], inputs[0], own, 2 * n)))
    for part in segments:
        if together:
            settle(rate, states[part.start], inputs[0], own, 2 * n)
        (advance_together if together else _advance)(rate, states[part], inputs[0], np.array(time[part]), own, 2 * n)
    return np.asarray(kernel.rows("actuation_p", states, inputs, p))


@njit(  # type: ignore[untyped-decorator]
    types.void(RATE, MATRIX, VECTOR, VECTOR, VECTOR, types.int64), cache=True, error_model="numpy"
)
def _advance(rate: Any, states: Array, control: Array, time: Array, p: Array, first: int) -> None:
    """Fill the hidden part of ``states`` (N, nx), columns ``first`` and on, in place."""
    count, size = states.shape
    hidden = size - first
    x, plain, nudged = np.empty(size), np.empty(hidden), np.empty(hidden)
    for k in range(count - 1):
        step = time[k + 1] - time[k]
        for i in range(first):
            x[i] = 0.5 * (states[k, i] + states[k + 1, i])
        for i in range(hidden):
            x[first + i] = states[k, first + i]
        rate(x, control, p, plain)
        for i in range(hidden):
            x[first + i] += NUDGE * (1.0 + abs(states[k, first + i]))
        rate(x, control, p, nudged)
        for i in range(hidden):
            slope = step * (nudged[i] - plain[i]) / (NUDGE * (1.0 + abs(states[k, first + i])))
            share = 1.0 + 0.5 * slope if abs(slope) < 1e-5 else np.expm1(min(slope, 50.0)) / slope
            states[k + 1, first + i] = states[k, first + i] + step * plain[i] * share
