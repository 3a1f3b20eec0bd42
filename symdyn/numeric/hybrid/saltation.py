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
    nx = len(machine.kernel.states)
    guards, bounds = (_by_parameters(machine, name, mode, z)[:, which] for name in ("guards", "bounds"))
    for k, (old, new) in enumerate(zip(before, after, strict=True)):
        if old != new:
            place = _place(machine, mode, k, old, new)
            if place is not None:
                slope = guards[place.guard]
                if place.bound is not None:
                    slope = slope - place.sign * bounds[place.bound]
                found.append(Guard(float(place.row @ z) - place.level, float(place.row @ rates), place.row[:nx], slope))
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


@dataclass(frozen=True, slots=True)
class _Place:
    """A guard ``row`` z - ``level``, by its number among the guards; ``level`` is ``sign`` times a bound."""

    row: Array  # (n,)
    level: float
    guard: int
    sign: int = 1
    bound: int | None = None


def _place(machine: Machine, mode: LinearMode, k: int, old: int, new: int) -> _Place | None:
    """What switch ``k`` watches as it goes from ``old`` to ``new``; None for a friction that sets off."""
    base = mode.base
    nf, nc, nl = (machine.count(kind) for kind in (FRICTION, CONTACT, LIMIT))
    if k < nf:
        return None if old == 0 else _Place(base.speeds[k], 0.0, k)
    way = 1 if (new or old) > 0 else -1
    if k < nf + nc:
        c = k - nf
        if 0 in (old, new):
            return _Place(base.gap[c], way * float(base.gap_half[c]), k, way, c)
        return _Place(base.high[c], 0.0, k + nc) if way > 0 else _Place(base.low[c], 0.0, k + 2 * nc)
    m = k - nf - nc
    side = 1 if way > 0 else 0
    return _Place(base.argument[m], float(base.limits[m, side]), nf + 3 * nc + m, 1, nc + side * nl + m)


def _by_parameters(machine: Machine, name: str, mode: LinearMode, z: Array) -> Array:
    """(rows, np) derivatives of "guards" or "bounds" at z; no rows where the machine has none."""
    nx, nw = len(machine.kernel.states), mode.output.shape[1]
    found = machine.call(f"{name}_parameter_jacobian", z[:nx], mode.output @ z[nx : nx + nw], mode.modes)
    count = len(machine.kernel.parameters)
    return found.reshape(found.size // max(1, count), count)


def _distance(guard: Guard) -> float:
    """Time from the root of a guard."""
    return abs(guard.value / guard.rate) if guard.rate else np.inf
