"""What an event does to sensitivities: its time depends on parameters and start, and the rates jump there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import NumericalError, Problem
from symdyn.numeric.hybrid.linear_mode import LinearMode, levers_by_parameters
from symdyn.numeric.hybrid.machine import CONTACT, FRICTION, LIMIT, Machine

Array = NDArray[np.float64]

NEAR = 1e-9  # s, within which a guard that is crossed has its root
CONTINUOUS = 1e-6  # jump of the rates, over their size, that the tolerance of event times explains


@dataclass(frozen=True, slots=True)
class Guard:
    """A guard near its root: its ``value``, its ``rate`` in time, and its derivatives by state and by parameter."""

    value: float
    rate: float
    by_state: Array  # (nx,)
    by_parameters: Array  # (q,)


def crossed(
    machine: Machine, mode: LinearMode, before: Sequence[int], after: Sequence[int], z: Array, which: Sequence[int]
) -> Guard | None:
    """The guard that made the switches change; None where friction just sets off, over which rates are continuous.

    Of several at one instant, the one nearest to its root: the others follow from it.
    """
    found = []
    rates = mode.a @ z
    by_p, bounds_by_p = _by_parameters(machine, mode, z, which)
    for k, (old, new) in enumerate(zip(before, after, strict=True)):
        if old != new:
            place = _place(machine, mode, k, old, new)
            if place is not None:
                row, bound, guard, limit = place
                slope = by_p[guard] - (0.0 if limit is None else _sign(limit) * bounds_by_p[limit[1]])
                value, rate = float(row @ z) - bound, float(row @ rates)
                found.append(Guard(value, rate, row[: len(machine.kernel.states)], slope))
    return min(found, key=_distance) if found else None


def jumped(s: Array, guard: Guard, start: int, before: Array, after: Array, time: float) -> Array:
    """Sensitivities (nx, q) after an event; of its columns, those from ``start`` on are not by parameters.

    S+ = S- + (f+ - f-) (dg/dx S- + dg/dp) / (dg/dt), with the rates ``before`` f- and ``after`` f+ (Aizerman
    and Gantmakher 1958). Raises NumericalError (SD303) where the guard is grazed: no derivative exists there.
    """
    jump = after - before
    size = np.abs(jump).max(initial=0.0) / max(np.abs(before).max(initial=0.0), np.abs(after).max(initial=0.0), 1e-300)
    if not abs(guard.value) <= NEAR * abs(guard.rate) and size <= CONTINUOUS:
        return s
    if guard.rate == 0.0 or not np.isfinite(1.0 / guard.rate):
        raise NumericalError(
            Problem("SD303", f"no sensitivity from t = {time:.9g} s on: an event is touched there, not crossed")
        )
    shift = guard.by_state @ s
    shift[:start] += guard.by_parameters
    return np.asarray(s + np.outer(jump, shift / guard.rate))


def stopped(machine: Machine, mode: LinearMode, s: Array, z: Array, which: Sequence[int]) -> Array:
    """Sensitivities with those of speeds that stick at what keeps them zero, along what frictions do."""
    if not mode.stuck:
        return s
    nx, stuck = len(machine.kernel.states), list(mode.stuck)
    speeds, pull = mode.base.speeds[stuck][:, :nx], mode.base.friction[:nx, stuck]
    left = speeds @ s
    if len(which):
        levers = levers_by_parameters(machine, mode)[stuck][:, :, which]
        left[:, : len(which)] += np.einsum("kxq,x->kq", levers, z[:nx])
    return np.asarray(s - pull @ np.linalg.solve(speeds @ pull, left))


def _place(
    machine: Machine, mode: LinearMode, k: int, old: int, new: int
) -> tuple[Array, float, int, tuple[int, int] | None] | None:
    """Row over z, bound, number among the guards, and (sign, number) of the bound, of the switch that changes."""
    base = mode.base
    nf, nc, nl = (machine.count(kind) for kind in (FRICTION, CONTACT, LIMIT))
    if k < nf:
        return None if old == 0 else (base.speeds[k], 0.0, k, None)
    way = 1 if (new or old) > 0 else -1
    if k < nf + nc:
        c = k - nf
        if 0 in (old, new):
            return base.gap[c], way * float(base.gap_half[c]), k, (way, c)
        return (base.high[c] if way > 0 else base.low[c]), 0.0, k + (nc if way > 0 else 2 * nc), None
    m = k - nf - nc
    side = 1 if way > 0 else 0
    return base.argument[m], float(base.limits[m, side]), nf + 3 * nc + m, (1, nc + side * nl + m)


def _sign(limit: tuple[int, int]) -> float:
    return float(limit[0])


def _by_parameters(machine: Machine, mode: LinearMode, z: Array, which: Sequence[int]) -> tuple[Array, Array]:
    """d guards / d p and d bounds / d p at z, of the parameters ``which``."""
    nx, nw = len(machine.kernel.states), mode.output.shape[1]
    x, u = z[:nx], mode.output @ z[nx : nx + nw]
    names = ("guards_parameter_jacobian", "bounds_parameter_jacobian")
    found = [machine.call(name, x, u, mode.modes) for name in names]
    return tuple(f[:, which] if f.size else np.zeros((0, len(which))) for f in found)  # type: ignore[return-value]


def _distance(guard: Guard) -> float:
    """Time from the root of a guard."""
    return abs(guard.value / guard.rate) if guard.rate else np.inf
