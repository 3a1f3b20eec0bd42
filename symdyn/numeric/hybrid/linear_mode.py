"""One mode of an affine machine as a linear system, and its derivatives by the parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.affine_modes import Base, mode_matrix
from symdyn.numeric.hybrid.machine import FRICTION, Machine
from symdyn.numeric.hybrid.spans import mode_of

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LinearMode:
    """dz/dt = a z with z = [x, signals, 1] (n,); ``sigma`` (nf, n) z is each friction's share of its limit.

    ``output`` (nu, nw) makes inputs of the signals; ``modes`` (S,) are those of contacts and limits, friction 0.
    """

    base: Base
    a: Array
    sigma: Array
    output: Array
    modes: Array
    stuck: tuple[int, ...]


def linear_mode(machine: Machine, switches: Sequence[int], system: Array, output: Array) -> LinearMode:
    """The mode of ``switches``, with the inputs of an exosystem."""
    nf = machine.count(FRICTION)
    modes = mode_of(switches)
    stacked = machine.base(_number(modes[nf:]), system[None], output[None], machine.parameters[None])
    wide = Base(*(part[0] for part in stacked))
    n = machine.size + len(system) + 1
    sigma = np.zeros((nf, len(wide.a)))
    a = mode_matrix(wide, np.array(switches, dtype=np.int64), sigma, n - 1)[:n, :n].copy()
    base, sigma = _narrow(wide, n), sigma[:, :n].copy()
    modes[:nf] = 0.0
    return LinearMode(base, a, sigma, output, modes, tuple(k for k in range(nf) if switches[k] == 0))


def _number(held: Array) -> int:
    """Of a combination of contacts and limits, as ``affine_switches.base_of`` counts."""
    number = 0
    for k in held:
        number = number * 3 + int(k) + 1
    return number


def _narrow(base: Base, n: int) -> Base:
    """Without the entries that only fill up vectors."""
    speeds, gap, high, low, argument = (
        part[:, :n].copy() for part in (base.speeds, base.gap, base.high, base.low, base.argument)
    )
    return Base(
        base.a[:n, :n].copy(), base.friction[:n].copy(), speeds, gap, high, low, argument, base.gap_half, base.limits
    )


def by_parameters(machine: Machine, mode: LinearMode, which: Sequence[int]) -> Array:
    """(q, n, n) d a / d p of the parameters ``which``.

    d rates / d p is affine in state, input and shares, so that its values at the unit vectors are all of it.
    Where friction sticks, its share changes with p so that the speed stays zero.
    """
    n, nx, nw = len(mode.a), len(machine.kernel.states), mode.output.shape[1]
    found = np.zeros((len(which), n, n))
    if not len(which):
        return found
    z = np.eye(n)
    still = _rates_by_parameters(machine, np.zeros(n), mode, np.zeros(len(mode.sigma)))[:, which]
    for i in (*range(nx + nw), n - 1):
        column = _rates_by_parameters(machine, z[i], mode, mode.sigma[:, i])[:, which]
        found[:, :nx, i] = (column if i == n - 1 else column - still).T
    if mode.stuck:
        stuck = list(mode.stuck)
        pull, speeds = mode.base.friction[:, stuck], mode.base.speeds[stuck]
        levers = levers_by_parameters(machine, mode)[np.ix_(stuck, range(nx), which)]
        change = speeds @ found + np.moveaxis(levers, 2, 0) @ mode.a[:nx]
        found -= pull @ np.linalg.solve(speeds @ pull, change)
    return found


def _rates_by_parameters(machine: Machine, z: Array, mode: LinearMode, sigma: Array) -> Array:
    nx, nw = len(machine.kernel.states), mode.output.shape[1]
    s = mode.modes.copy()
    s[: len(sigma)] = sigma
    return machine.call("state_derivative_parameter_jacobian", z[:nx], mode.output @ z[nx : nx + nw], s)


def levers_by_parameters(machine: Machine, mode: LinearMode) -> Array:
    """(nf, nx, np) derivatives of the speeds that frictions oppose, by state and parameter."""
    nf, nx, u = len(mode.sigma), len(machine.kernel.states), np.zeros(len(mode.output))
    columns = [machine.call("guards_parameter_jacobian", x, u, mode.modes)[:nf] for x in np.eye(nx)]
    return np.stack(columns, axis=1)
