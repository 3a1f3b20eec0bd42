"""Inputs, sensors and states of a linear model by their names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import control
import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import Problem, UsageError
from symdyn.base.linear_system import Array, Derivatives, LinearSystem
from symdyn.base.wording import did_you_mean


@dataclass(frozen=True, slots=True, eq=False)
class Channel:
    """One input and one output: ``y = row x + feed u_k``, where ``k`` is the number of the input."""

    input: str
    output: str
    k: int
    row: Array  # (nx,)
    feed: float
    sensor: int | None  # number of the sensor, None for a state
    unit: str  # of output per input


def channel(system: LinearSystem, input: str | None = None, output: str | None = None) -> Channel:
    """By names; the first input and the first sensor (or state) where none are given.

    Any state may be an output. Raises UsageError (SD305) for a name that the model does not have, or a machine
    without inputs.
    """
    if not system.inputs:
        raise UsageError(Problem("SD305", f"{system.name} has no inputs"))
    shown = input if input is not None else system.inputs[0]
    seen: str = output if output is not None else (*system.outputs, *system.states)[0]
    k = _index(shown, system.inputs, "input")
    if seen in system.outputs:
        j = system.outputs.index(seen)
        sensor: int | None = j
        row, feed, unit = system.c[j], float(system.d[j, k]), system.output_units[j]
    else:
        i = _index(seen, system.states, "output", (*system.outputs, *system.states))
        sensor, row, feed, unit = None, np.eye(len(system.states))[i], 0.0, system.state_units[i]
    return Channel(shown, seen, k, row, feed, sensor, per_unit(unit, system.input_units[k]))


def channel_derivatives(chosen: Channel, d: Derivatives) -> tuple[Array, Array]:
    """Of the channel's row (np, nx) and feed (np,)."""
    if chosen.sensor is None:
        return np.zeros((len(d.c), len(chosen.row))), np.zeros(len(d.c))
    return d.c[:, chosen.sensor], d.d[:, chosen.sensor, chosen.k]


def as_control(system: LinearSystem) -> control.StateSpace:
    """A python-control system; dots in names become underscores (its rule). Outputs are sensors, else all states.

    Raises numpy.linalg.LinAlgError where an inertia or an inductance is zero.
    """
    a, b = np.linalg.solve(system.e, system.f), np.linalg.solve(system.e, system.h)
    c, d = system.c, system.d
    names = [name.replace(".", "_") for name in system.outputs]
    if not system.outputs:
        c, d = np.eye(len(a)), np.zeros((len(a), b.shape[1]))
        names = [f"{name.replace('.', '_')}_" for name in system.states]
    plain = [[name.replace(".", "_") for name in group] for group in (system.states, system.inputs)]
    return control.ss(a, b, c, d, states=plain[0], inputs=plain[1], outputs=names, name=system.name)


def short_names(addresses: Sequence[str]) -> tuple[str, ...]:
    """``axis1.motor`` as ``motor`` where no other address ends so."""
    last = [address.rpartition(".")[2] for address in addresses]
    return tuple(tail if last.count(tail) == 1 else whole for tail, whole in zip(last, addresses, strict=True))


def grid(low: float, high: float, points: int) -> NDArray[np.float64]:
    """(points,) frequencies in Hz, evenly spaced in their logarithm.

    Raises UsageError (SD302) unless 0 < low < high are finite and there are at least two points.
    """
    if not (np.isfinite(low) and np.isfinite(high) and 0 < low < high and points >= 2):
        raise UsageError(Problem("SD302", f"a band of frequencies is 0 < from < to in Hz, not {low:g} to {high:g}"))
    return np.geomspace(low, high, points)


def _index(name: str, names: Sequence[str], kind: str, known: Sequence[str] | None = None) -> int:
    if name not in names:
        listed = list(known if known is not None else names)
        hint = did_you_mean(name, listed, f"{kind}s")
        raise UsageError(Problem("SD305", f"no {kind} `{name}`", hint=hint))
    return names.index(name)


def per_unit(unit: str, per: str) -> str:
    """The unit of an output per input, "1" where they are the same."""
    return "1" if unit == per else f"{unit} / {_bracketed(per)}"


def _bracketed(unit: str) -> str:
    return f"({unit})" if " " in unit or "/" in unit else unit
