"""Exact sensitivities of a trajectory to parameters and start, across its events."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from symdyn.base.errors import InputError, Problem
from symdyn.emit.kernel import Kernel
from symdyn.numeric.hybrid.affine_simulation import simulate_affine
from symdyn.numeric.hybrid.exponential import growth_rate, legendre
from symdyn.numeric.hybrid.linear_mode import LinearMode, by_parameters, linear_mode
from symdyn.numeric.hybrid.machine import Machine
from symdyn.numeric.hybrid.saltation import crossed, jumped, stopped
from symdyn.numeric.hybrid.samples import due_at, refuse_timing, samples, updated_slopes
from symdyn.numeric.hybrid.signals import Signal, exosystem
from symdyn.numeric.hybrid.spans import Span, settled, spans
from symdyn.numeric.hybrid.trajectory import CLOSE, HybridTrajectory

Array = NDArray[np.float64]

NODES, WEIGHTS = legendre(8)
REACH = 1.0  # of the shortest step, over the machine's fastest time
RESOLUTION = 14  # digits after the point of a step in s, so that equal ones are computed once


@dataclass(frozen=True, slots=True)
class Sensitivities:
    """``values`` (N, nx, q): d states / d each of ``names``, parameters first, then "start of" each state."""

    trajectory: HybridTrajectory
    names: tuple[str, ...]
    values: Array

    def table(self, kernel: Kernel) -> Mapping[str, Array]:
        """Columns of those by parameters, for a CSV file: "time [s]", "d axis1.motor.q / d c_3 [rad/(N m/rad)]", ..."""
        columns = {"time [s]": self.trajectory.time}
        units = dict(zip(kernel.parameters, kernel.parameter_units, strict=True))
        for k, name in enumerate(self.names):
            for i, (state, unit) in enumerate(zip(kernel.states, kernel.state_units, strict=True)):
                if name in units:
                    columns[f"d {state} / d {name} [{unit}/({units[name]})]"] = self.values[:, i, k]
        return columns


@dataclass(frozen=True, slots=True)
class _Step:
    """exp(a h) (n, n), and its derivatives by the parameters (q, n, n)."""

    over: Array
    change: Array


def simulate_sensitivities(
    machine: Machine,
    time: Array,
    signals: Sequence[Signal],
    *,
    start: Array | None = None,
    parameters: Sequence[str] = (),
    initial: bool = False,
) -> Sensitivities:
    """The trajectory of ``simulate_affine``, with its derivatives by ``parameters`` and, if ``initial``, its start.

    Between events by the derivative of the exponential; at events with the shift of their time, at samples by that of
    the sampled law. They hold for changes that keep the order of the events. A start at which friction sticks has no
    sensitivity to its speed.

    Raises InputError (SD302) for a machine that is not affine in every mode or a name that is no parameter, SD453 for a
    parameter that moves the instants of samples, NumericalError (SD303) where an event is touched and not crossed; and
    what ``simulate_affine`` raises.
    """
    kernel = machine.kernel
    unknown = [name for name in parameters if name not in kernel.parameters]
    if unknown:
        raise InputError(Problem("SD302", f"no such parameter: {', '.join(unknown)}"))
    if not machine.affine:
        raise InputError(Problem("SD302", "exact sensitivities need a machine that is affine in every mode"))
    which = [kernel.parameters.index(name) for name in parameters]
    refuse_timing(machine, parameters)
    trajectory = simulate_affine(machine, time, signals, start=start)
    names = (*parameters, *((f"start of {name}" for name in kernel.states) if initial else ()))
    x = np.zeros(trajectory.states.shape[1]) if start is None else np.array(start, dtype=np.float64)
    return Sensitivities(trajectory, names, _Follower(machine, signals, which).follow(trajectory, x, initial))


class _Follower:
    """Modes and steps met on the way, each made once."""

    def __init__(self, machine: Machine, signals: Sequence[Signal], which: Sequence[int]) -> None:
        self.machine, self.signals, self.which = machine, signals, which
        self.modes: dict[tuple[object, ...], tuple[LinearMode, Array]] = {}
        self.steps: dict[tuple[int, float], _Step] = {}

    def follow(self, trajectory: HybridTrajectory, x: Array, initial: bool) -> Array:
        machine, which, time = self.machine, self.which, trajectory.time
        nx, q = trajectory.states.shape[1], len(which)
        s = np.hstack([np.zeros((nx, q)), np.eye(nx)]) if initial else np.zeros((nx, q))
        found = np.zeros((len(time), *s.shape))
        close = CLOSE * float(time[1] - time[0])
        instants = samples(machine.clocks, float(time[0]), float(time[-1]), closed=True)
        sampled = -np.inf

        def sample(x: Array, s: Array, now: float) -> tuple[Array, Array]:
            nonlocal sampled
            due = due_at(instants, now, close)
            if not len(due) or now <= sampled + close:
                return x, s
            sampled = now
            return updated_slopes(machine, x, s, which, self.signals, now, due)

        x, s = sample(x, s, float(time[0]))
        last: tuple[Span, LinearMode] | None = None
        for span in spans(trajectory, machine.switches, tuple(machine.kernel.module.SWITCH_KINDS)):
            mode, slopes = self._mode(span)
            z = self._z(x, span, len(mode.a))
            if last is None or last[0].switches != span.switches:
                if last is not None and last[0].begun == span.begun:
                    s = self._through(s, z, last, (span, mode))
                x = settled(machine, span.switches, x, mode.output @ z[nx : nx + mode.output.shape[1]])
                z[:nx] = x
                s = stopped(machine, mode, s, z, which)
            if last is None:
                found[0] = s
            last = span, mode
            step = self._step(mode, slopes, span.last - span.first)
            s = step.over[:nx, :nx] @ s
            s[:, :q] += (step.change @ z)[:, :nx].T
            x, s = sample((step.over @ z)[:nx], s, span.last)
            if span.row is not None:
                found[span.row] = s
                x = np.array(trajectory.states[span.row])
        return found

    def _through(self, s: Array, z: Array, old: tuple[Span, LinearMode], new: tuple[Span, LinearMode]) -> Array:
        """Across the event between two spans."""
        nx = len(s)
        before, after = old[0].switches, new[0].switches
        guard = crossed(self.machine, old[1], before, after, z, self.which)
        if guard is None:
            return s
        rates = (old[1].a @ z)[:nx], (new[1].a @ z)[:nx]
        return jumped(s, guard, len(self.which), *rates, new[0].first)

    def _mode(self, span: Span) -> tuple[LinearMode, Array]:
        system, output, _ = exosystem([signal.piece_at(span.begun) for signal in self.signals], span.first)
        key = (span.switches, system.tobytes(), output.tobytes())
        if key not in self.modes:
            mode = linear_mode(self.machine, span.switches, system, output)
            self.modes[key] = mode, by_parameters(self.machine, mode, self.which)
        return self.modes[key]

    def _z(self, x: Array, span: Span, n: int) -> Array:
        w = exosystem([signal.piece_at(span.begun) for signal in self.signals], span.first)[2]
        z = np.zeros(n)
        z[: len(x)], z[len(x) : len(x) + len(w)], z[-1] = x, w, 1.0
        return z

    def _step(self, mode: LinearMode, slopes: Array, length: float) -> _Step:
        h = round(length, RESOLUTION)
        key = (id(mode), h)
        if key not in self.steps:
            self.steps[key] = _step(mode.a, slopes, h)
        return self.steps[key]


def _step(a: Array, slopes: Array, length: float) -> _Step:
    """By quadrature over a short step, and doubling: d exp(2 h a) = d exp(h a) exp(h a) + exp(h a) d exp(h a)."""
    doublings, h = 0, length
    rate = growth_rate(a)
    while h * rate > REACH:
        doublings, h = doublings + 1, 0.5 * h
    over, change = expm(a * h), np.zeros_like(slopes)
    for point, weight in zip(NODES, WEIGHTS, strict=True):
        change += h * weight * (expm(a * (h * (1.0 - point))) @ slopes @ expm(a * (h * point)))
    for _ in range(doublings):
        change = change @ over + over @ change
        over = over @ over
    return _Step(over, change)
