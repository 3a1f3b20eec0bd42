"""Hidden states driven by the measured motion: friction that remembers needs no guess of what it was."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from symdyn.base import symbols
from symdyn.emit.kernel import Kernel
from symdyn.physics import catalogue
from symdyn.physics.effect import MOVING, Effect, Values
from symdyn.spec.places import places
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

NUDGE = 1e-7  # of a state, for the slope of its rate
HALF = 0.5  # size of a matrix of which the series of the exponential is summed,
TERMS = 10  # to so many terms: 1e-10
MOST = 60  # halvings until then
SAME = 1e-6  # relative change of a slope, or of a step, below which it is the nudge's


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


def remembered(kernel: Kernel, q: Array, qd: Array, time: Array, segments: tuple[slice, ...], p: Array) -> Array:
    """(N, n) effort that the hidden states exert at the joints along a motion q, qd (N, n).

    The kernel's own rates are integrated from sample to sample with the motion halfway between them, by
    the exponential Euler rule: exact where a rate is linear in its state, and stable however fast
    it is. Every segment begins from zero; states that act on one another (an elastic load) begin where their rates
    vanish: in step with the motion.
    """
    states = np.zeros((len(time), len(kernel.states)))
    n = q.shape[1]
    states[:, :n], states[:, n : 2 * n] = q, qd
    inputs = np.zeros((len(time), len(kernel.inputs)))
    rate, own = kernel.hidden_state_derivative_p_into, np.array(p)  # copies: compiled code wants what it could write to
    coupled = _are_coupled(rate, states[0], inputs[0], own, 2 * n)
    for part in segments:
        if coupled:
            _settle(rate, states[part.start], inputs[0], own, 2 * n)
        (_advance_together if coupled else _advance)(rate, states[part], inputs[0], np.array(time[part]), own, 2 * n)
    return np.asarray(kernel.actuation_p_batch(states, inputs, p))


def swings(kernel: Kernel, p: Array) -> bool:
    """Whether it has hidden states that act on one another: how they began shows for long."""
    n, count = len(kernel.coordinates), len(kernel.states)
    if count < 2 * n + 2:
        return False
    rate, inputs = kernel.hidden_state_derivative_p_into, np.zeros(len(kernel.inputs))
    return _are_coupled(rate, np.zeros(count), inputs, np.array(p), 2 * n)


def started(kernel: Kernel, time: Array, segments: tuple[slice, ...], p: Array) -> Array:
    """(N, n, m) effort that hidden states which act on one another exert at joints that stand, one column for each of
    them and each segment, at whose beginning it is one.

    How they began is in no recording, and what swings goes on for long.
    """
    n, count = len(kernel.coordinates), len(kernel.states)
    inputs, own = np.zeros((len(time), len(kernel.inputs))), np.array(p)
    found = []
    for part in segments:
        for i in range(2 * n, count):
            states = np.zeros((len(time), count))
            states[part.start, i] = 1.0
            _advance_together(
                kernel.hidden_state_derivative_p_into, states[part], inputs[0], np.array(time[part]), own, 2 * n
            )
            found.append(kernel.actuation_p_batch(states, inputs, p))
    return np.stack(found, axis=2)


_vector, _matrix = (types.Array(types.float64, d, "C") for d in (1, 2))
_rate = types.FunctionType(types.none(_vector, _vector, _vector, _vector))  # any kernel's: so it is compiled once


@njit(  # type: ignore[untyped-decorator]
    types.void(_rate, _matrix, _vector, _vector, _vector, types.int64), cache=True, error_model="numpy"
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


@njit(types.void(_rate, _vector, _vector, _vector, _vector, _matrix), cache=True, error_model="numpy")  # type: ignore[untyped-decorator]
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


def _are_coupled(rate: Any, x: Array, control: Array, p: Array, first: int) -> bool:
    """Whether the rate of a hidden state depends on another one."""
    hidden = len(x) - first
    slopes = np.zeros((hidden, hidden))
    _jacobian(rate, np.array(x), control, p, np.zeros(hidden), slopes)
    return bool(np.any(slopes - np.diag(np.diag(slopes))))


def _settle(rate: Any, state: Array, control: Array, p: Array, first: int) -> None:
    """Hidden states that act on one another where their rates vanish, in place."""
    hidden = len(state) - first
    plain, slopes = np.zeros(hidden), np.zeros((hidden, hidden))
    _jacobian(rate, np.array(state), control, p, plain, slopes)
    across = slopes - np.diag(np.diag(slopes))
    alone = ~(np.any(across, axis=0) | np.any(across, axis=1))
    slopes[alone], plain[alone] = np.eye(hidden)[alone], 0.0
    state[first:] -= np.linalg.solve(slopes, plain)


@njit(  # type: ignore[untyped-decorator]
    types.void(_rate, _matrix, _vector, _vector, _vector, types.int64), cache=True, error_model="numpy"
)
def _advance_together(rate: Any, states: Array, control: Array, time: Array, p: Array, first: int) -> None:
    """The same for states that act on one another: z + h phi1(h J) f + h phi2(h J) (f' - f).

    Rates go straight from f, with the motion at a sample, to f', with that at the next. phi1 and phi2 are parts of
    exp [[h J, 1, 0], [0, 0, 1], 0], computed anew where the slopes changed: those of what swings freely do not.
    """
    count, size = states.shape
    hidden = size - first
    x, plain, slopes = np.empty(size), np.empty(hidden), np.empty((hidden, hidden))
    before, after = np.empty(hidden), np.empty(hidden)
    known, spent, shares = np.full((hidden, hidden), np.inf), 0.0, np.empty((hidden, 2 * hidden))
    for k in range(count - 1):
        step = time[k + 1] - time[k]
        for i in range(first):
            x[i] = 0.5 * (states[k, i] + states[k + 1, i])
        for i in range(first, size):
            x[i] = states[k, i]
        _jacobian(rate, x, control, p, plain, slopes)
        changed = abs(step - spent) > SAME * step
        for i in range(hidden):
            for j in range(hidden):
                changed = changed or not abs(slopes[i, j] - known[i, j]) <= SAME * (1.0 + abs(slopes[i, j]))
        if changed:
            known[:], spent = slopes, step
            whole = np.zeros((3 * hidden, 3 * hidden))
            whole[:hidden, :hidden] = step * slopes
            whole[: 2 * hidden, hidden:] = np.eye(2 * hidden)
            halvings = 0
            while np.abs(whole).max() * hidden > HALF and halvings < MOST:
                whole *= 0.5
                halvings += 1
            total, power = np.eye(3 * hidden), np.eye(3 * hidden)
            for term in range(1, TERMS):
                power = power @ whole / term
                total += power
            for _ in range(halvings):
                total = total @ total
            shares[:] = step * total[:hidden, hidden:]
        x[:first] = states[k, :first]
        rate(x, control, p, before)
        x[:first] = states[k + 1, :first]
        rate(x, control, p, after)
        for i in range(hidden):
            moved = 0.0
            for j in range(hidden):
                moved += shares[i, j] * before[j] + shares[i, hidden + j] * (after[j] - before[j])
            states[k + 1, first + i] = states[k, first + i] + moved
