"""The instants at which clocks go off, and what they do to the state."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, Problem
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.signals import Signal

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

AT_ONCE = 1e-12  # s between instants that are one


def samples(clocks: Array, first: float, last: float, closed: bool) -> tuple[Array, Ints]:
    """Instants (M,) from ``first`` to ``last`` in order, and which clock goes off at each; ``closed``: last included.

    ``clocks`` (K, 2) are periods and delays in s: clock k goes off at delay + n period, n = 0, 1, ... Those of one
    instant stay in the order of the clocks.
    """
    when, which = [np.zeros(0)], [np.zeros(0, np.int64)]
    end = last + AT_ONCE if closed else last - AT_ONCE
    for k, (period, delay) in enumerate(clocks):
        start = max(0, int(np.ceil((first - AT_ONCE - delay) / period)))
        count = max(0, int(np.floor((end - delay) / period)) + 1 - start)
        times = delay + period * np.arange(start, start + count)
        when.append(times)
        which.append(np.full(count, k, np.int64))
    times, owners = np.concatenate(when), np.concatenate(which)
    order = np.lexsort((owners, np.round(times / AT_ONCE)))
    return times[order], owners[order]


def due_at(instants: tuple[Array, Ints], time: float, close: float) -> Ints:
    """The clocks that go off at ``time``, or as ``close`` to it as makes no difference, in s."""
    times, owners = instants
    return owners[np.searchsorted(times, time - close) : np.searchsorted(times, time + close)]


def updated(machine: Machine, x: Array, signals: Sequence[Signal], time: float, due: Ints) -> Array:
    """The state after the clocks ``due`` have gone off, one after the other."""
    u, s = _asked(machine, signals, time)
    x, nx = x.copy(), len(machine.kernel.states)
    for clock in due:
        new = machine.call("updates", x[:nx], u, s)[clock]
        x[nx - len(new) : nx] = new
    return x


def _asked(machine: Machine, signals: Sequence[Signal], time: float) -> tuple[Array, Array]:
    """Inputs at a sample; the modes, which no sampled law reads."""
    return np.array([float(signal.at(np.array(time))) for signal in signals]), np.zeros(len(machine.switches))


def updated_slopes(
    machine: Machine, x: Array, slopes: Array, which: Sequence[int], signals: Sequence[Signal], time: float, due: Ints
) -> tuple[Array, Array]:
    """The same with the state's derivatives: its first by the parameters ``which``, others by anything else.

    ``slopes`` (nx, q). Where a limit is reached the law has slope zero; the instants themselves are given.
    """
    u, s = _asked(machine, signals, time)
    nx, q, clocks = len(machine.kernel.states), len(which), len(machine.clocks)
    slopes = slopes.copy()
    for clock in due:
        by_state = machine.call("updates_state_jacobian", x[:nx], u, s).reshape(clocks, -1, nx)[clock]
        new = by_state @ slopes[:nx]
        if q:
            by_parameters = machine.call("updates_parameter_jacobian", x[:nx], u, s)
            new[:, :q] += by_parameters.reshape(clocks, len(new), -1)[clock][:, which]
        slopes[nx - len(new) : nx] = new
        x = updated(machine, x, signals, time, np.array([clock]))
    return x, slopes


def timing(machine: Machine) -> tuple[str, ...]:
    """The parameters that move the instants of samples; of a machine that is affine in every mode."""
    x, u, s = (np.zeros(len(v)) for v in (machine.kernel.states, machine.kernel.inputs, machine.switches))
    names = machine.kernel.parameters
    moves = machine.call("clocks_parameter_jacobian", x, u, s).reshape(-1, max(1, len(names)))
    return tuple(name for k, name in enumerate(names) if np.any(moves[:, k]))


def refuse_timing(machine: Machine, names: Sequence[str]) -> None:
    """InputError (SD453) where one of the parameters ``names`` moves the instants of samples."""
    moving = [name for name in timing(machine) if name in names]
    if moving:
        what = f"no sensitivity to {', '.join(moving)}: samples would be taken at other times"
        raise InputError(Problem("SD453", what, hint="simulate at two values"))
