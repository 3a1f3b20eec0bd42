"""Fourier coefficients of one output over a period, and the period that is left when the start has died away."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import Problem, UsageError
from symdyn.base.wording import did_you_mean
from symdyn.numeric.hybrid.affine_simulation import simulate_affine
from symdyn.numeric.hybrid.machine import Machine, Observer
from symdyn.numeric.hybrid.signals import Signal
from symdyn.numeric.hybrid.simulate import simulate_events

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

CALM = 2  # comparisons in a row that must find no change; each waits twice as long as the one before
_PROBES = (10.0, 1000.0)
_SAME = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class Cycle:
    """One period: the output is the real part of the sum of ``harmonics``[k - 1] exp(j 2 pi k t / period)."""

    harmonics: Complex  # (H,)
    end: Array  # (nx,)
    events: int
    periods: int  # simulated up to its end
    settled: bool


@dataclass(frozen=True, slots=True, eq=False)
class Listener:
    """A machine and one of its sensors or states, listened to at the first ``highest`` harmonics of a period.

    ``samples`` 0: by resonators that are propagated with the machine, exactly, events included. Else by so many
    samples of a period, of which kinks leave an error of the order of 1 / samples^2.
    """

    machine: Machine
    output: str
    highest: int
    samples: int
    tolerance: float  # of the integration of a machine that is not propagated exactly

    def cycle(self, signals: Sequence[Signal], period: float, start: Array) -> Cycle:
        """The period from ``start`` (nx,) on; what drifts evenly over it is left out of its harmonics."""
        kernel = self.machine.kernel
        if self.samples:
            time = np.linspace(0.0, period, self.samples + 1)
            found = simulate_events(self.machine, time, signals, start=start, tolerance=self.tolerance)
            y = self.values(found.states, found.inputs)
            y = y[:-1] - (y[-1] - y[0]) * np.arange(self.samples) / self.samples
            harmonics = 2.0 * np.fft.rfft(y)[1 : self.highest + 1] / self.samples
            return Cycle(harmonics, found.states[-1], len(found.events), 1, False)
        row = affine_output(self.machine, self.output)
        assert row is not None
        nx = len(kernel.states)
        watched = replace(self.machine, observer=_resonators(row, 2 * np.pi / period, self.highest))
        begin = np.concatenate([start, np.zeros(2 * self.highest)])
        found = simulate_affine(watched, np.array([0.0, period]), signals, start=begin)
        end = found.states[-1, :nx]
        pairs = found.states[-1, nx:].reshape(-1, 2)
        y = self.values(np.stack([start, end]), found.inputs)
        drift = 1j * (y[1] - y[0]) * period / (2 * np.pi * np.arange(1, self.highest + 1))
        harmonics = 2.0 * (pairs[:, 0] + 1j * pairs[:, 1] - drift) / period
        return Cycle(harmonics, end, len(found.events), 1, False)

    def values(self, states: Array, inputs: Array) -> Array:
        """The output (N,) at states (N, nx) and inputs (N, nu)."""
        kernel = self.machine.kernel
        if self.output in kernel.states:
            return states[:, kernel.states.index(self.output)]
        k = kernel.outputs.index(self.output)
        modes = np.zeros(len(self.machine.switches))
        return np.array([self.machine.call("output", x, u, modes)[k] for x, u in zip(states, inputs, strict=True)])


def listener(
    machine: Machine, output: str | None, highest: int, *, exact: bool, samples: int, tolerance: float
) -> Listener:
    """To an output by name, the first sensor (or state) where none is given; exact where asked for and possible.

    Raises UsageError (SD305) for a name that the machine does not have.
    """
    kernel = machine.kernel
    known = (*kernel.outputs, *kernel.states)
    chosen = output if output is not None else known[0]
    if chosen not in known:
        raise UsageError(Problem("SD305", f"no output `{chosen}`", hint=did_you_mean(chosen, known, "outputs")))
    by_resonators = exact and machine.affine and affine_output(machine, chosen) is not None
    return Listener(machine, chosen, highest, 0 if by_resonators else samples, tolerance)


def settle(
    heard: Listener, signals: Sequence[Signal], period: float, start: Array, tolerance: float, most: int
) -> Cycle:
    """The first period from which on nothing changes but by ``tolerance``, or the last of ``most``, not settled.

    Periods are compared 1, 2, 4, 8 ... periods apart: what decays slowly then shows as well. The largest harmonic
    is the measure.
    """
    found = heard.cycle(signals, period, start)
    periods, wait, calm = 1, 1, 0
    while calm < CALM and periods + wait <= most:
        x = found.end
        if wait > 1:
            time = np.array([0.0, (wait - 1) * period])
            x = simulate_events(heard.machine, time, signals, start=x, tolerance=heard.tolerance).states[-1]
        after = heard.cycle(signals, period, x)
        change = np.abs(after.harmonics - found.harmonics).max()
        calm = calm + 1 if change <= tolerance * np.abs(after.harmonics).max() else 0
        found, periods, wait = after, periods + wait, 2 * wait
    return replace(found, periods=periods, settled=calm == CALM)


def affine_output(machine: Machine, output: str) -> tuple[Array, Array, float] | None:
    """(by state (nx,), by input (nu,), constant); None for an output that is not affine, such as an encoder's."""
    kernel = machine.kernel
    nx, nu = len(kernel.states), len(kernel.inputs)
    if output in kernel.states:
        return np.eye(nx)[kernel.states.index(output)], np.zeros(nu), 0.0
    k, modes = kernel.outputs.index(output), np.zeros(len(machine.switches))

    def at(v: Array) -> float:
        return float(machine.call("output", v[:nx], v[nx:], modes)[k])

    constant = at(np.zeros(nx + nu))
    slope = np.array([at(e) - constant for e in np.eye(nx + nu)])
    for size in _PROBES:
        probe = size * np.sin(1.0 + np.arange(nx + nu))
        if abs(at(probe) - constant - slope @ probe) > _SAME * (abs(constant) + np.abs(slope) @ np.abs(probe)):
            return None
    return slope[:nx], slope[nx:], constant


def _resonators(row: tuple[Array, Array, float], omega: float, highest: int) -> Observer:
    """dm_k/dt = j k omega m_k + y, whose value after a period from 0 is the integral of y exp(-j k omega t)."""
    by_state, by_input, constant = row
    size = 2 * highest
    system = np.zeros((size, size))
    for k in range(highest):
        system[2 * k, 2 * k + 1], system[2 * k + 1, 2 * k] = -(k + 1) * omega, (k + 1) * omega
    real = np.zeros(size)
    real[::2] = 1.0
    return Observer(system, np.outer(real, by_state), np.outer(real, by_input), real * constant)
