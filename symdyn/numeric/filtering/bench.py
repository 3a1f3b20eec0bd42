"""A model, part of it measured, under a Kalman filter: whitened innovations and how they change with parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel
from symdyn.numeric.filtering.kalman import run
from symdyn.numeric.filtering.signals import Signals

Array = NDArray[np.float64]

DEAF = 1e30  # variance of a measurement that a filter does not listen to


@dataclass(frozen=True, slots=True, eq=False)
class Noise:
    """Variances ``r`` (m,) of the measurements, and latent forces: Ornstein-Uhlenbeck processes.

    ``directions`` (np, l) says along which parameters each force acts, ``decay`` (l,) in 1/s is the inverse of its
    correlation time, ``power`` (l,) its variance.
    """

    r: Array
    directions: Array
    decay: Array
    power: Array


@dataclass(frozen=True, slots=True, eq=False)
class Pass:
    """One run of the filter: -log L, innovations (N, m), their variances, d innovations / d p, states (N, n + l)."""

    loss: float
    innovations: Array
    variances: Array
    slopes: Array
    states: Array

    @property
    def white(self) -> Array:
        """(N, m) independent, of variance 1 where the model holds."""
        return np.asarray(self.innovations / np.sqrt(self.variances))


class FilterBench:
    """Runs the filter on one recording; parameter vectors are those of the kernel."""

    def __init__(self, kernel: Kernel, signals: Signals, noise: Noise, held: bool = False, substeps: int = 1) -> None:
        """``held``: an input keeps its value over a step; else it goes straight to its next sample."""
        self.kernel, self.signals, self.noise = kernel, signals, noise
        self.held, self.substeps = held, substeps
        self.index = {name: i for i, name in enumerate(kernel.parameters)}
        u = signals.u
        self._slope = np.zeros_like(u)
        if not held:
            self._slope[:-1] = np.nan_to_num(np.diff(u, axis=0) / signals.steps[:-1, None])
        self._start, self._spread = _start(kernel, signals)
        module = kernel.module
        self._rates = (
            module.state_derivative_p_into,
            module.state_derivative_state_jacobian_p_into,
            module.state_derivative_input_jacobian_p_into,
            module.state_derivative_parameter_jacobian_p_into,
        )
        self._outputs = (
            (module.output_p_into, module.output_state_jacobian_p_into, module.output_parameter_jacobian_p_into)
            if kernel.outputs
            else (_nothing, _no_slope, _no_slope)
        )

    def with_noise(self, noise: Noise) -> FilterBench:
        return FilterBench(self.kernel, self.signals, noise, self.held, self.substeps)

    def filtered(self, p: Array, names: Sequence[str] = ()) -> Pass:
        """The filter at parameters ``p`` (np,), differentiated by those named."""
        s, noise = self.signals, self.noise
        count, m, n = len(s.y), s.y.shape[1], len(self.kernel.states)
        which = np.array([self.index[name] for name in names], dtype=np.int64)
        e, variances = np.zeros((count, m)), np.ones((count, m))
        slopes, states = np.zeros((count, m, len(which))), np.zeros((count, n + len(noise.decay)))
        loss = run(
            *self._rates, *self._outputs, s.u, self._slope, s.y, s.steps, np.ascontiguousarray(p), which, noise.r,
            s.index, np.ascontiguousarray(noise.directions), noise.decay, noise.power, self._start, self._spread,
            self.substeps, len(self.kernel.outputs), e, variances, slopes, states,
        )  # fmt: skip
        return Pass(float(loss), e, variances, slopes, states)

    def simulated(self, p: Array, start: Array, first: int, stop: int) -> Array:
        """(stop - first, m) what the channels would show from state ``start`` (n,) at sample ``first`` on."""
        s, n, m = self.signals, len(self.kernel.states), self.signals.y.shape[1]
        count, none = stop - first, np.zeros(0)
        shown = np.zeros((count, m))
        e, variances, slopes = np.zeros((count, m)), np.ones((count, m)), np.zeros((count, m, 0))
        run(
            *self._rates, *self._outputs, s.u[first:stop], self._slope[first:stop], shown, s.steps[first:stop],
            np.ascontiguousarray(p), np.zeros(0, dtype=np.int64), np.full(m, DEAF), s.index,
            np.zeros((len(p), 0)), none, none, start, np.zeros((n, n)), self.substeps, len(self.kernel.outputs),
            e, variances, slopes, np.zeros((count, n)),
        )  # fmt: skip
        return -e  # of measurements that are zero, and move nothing

    def residual(self, p: Array) -> Array:
        """(N, m) whitened innovations."""
        return self.filtered(p).white

    def columns(self, p: Array, names: Sequence[str]) -> Array:
        """(N, m, k) what a parameter takes off the whitened innovations, per unit."""
        done = self.filtered(p, names)
        return -done.slopes / np.sqrt(done.variances)[:, :, None]


def _start(kernel: Kernel, signals: Signals) -> tuple[Array, Array]:
    """(n,) state before the first sample and its covariance (n, n): what is measured, else rest with room around it.

    The parts of one drive move together, but for a twist.
    """
    n, coordinates = len(kernel.states), len(kernel.coordinates)
    x, cov = np.zeros(n), np.zeros((n, n))
    step = float(np.nanmedian(signals.steps))
    travel, speed, other = 0.0, 0.0, 1.0
    for c, index in enumerate(signals.index):
        values = signals.y[:, c]
        if index < n:
            x[index] = values[0]
        if index < coordinates:
            travel = max(travel, float(np.ptp(values)))
            speed = max(speed, float(np.std(np.diff(values))) / step)
        elif index < 2 * coordinates:
            speed = max(speed, float(np.std(values)))
        elif index < n:
            other = max(other, float(np.ptp(values)))
    speed = speed or 1.0
    travel = travel or speed * len(signals.y) * step
    measured = {int(i) for i in signals.index}
    joints = [name.partition(".")[0] for name in kernel.coordinates]
    for first, size, apart in ((0, 1e-2 * travel, 1e-4 * travel), (coordinates, speed, 1e-2 * speed)):
        for i in range(coordinates):
            same = [j for j in range(coordinates) if joints[j] == joints[i]]
            known = [first + j for j in same if first + j in measured]
            if known and first + i not in measured:
                x[first + i] = x[known[0]]
            for j in same:
                cov[first + i, first + j] = size**2
            cov[first + i, first + i] += apart**2
    for i in range(2 * coordinates, n):
        cov[i, i] = other**2
    return x, cov


@njit(cache=True)
def _nothing(x, u, p, out):  # type: ignore[no-untyped-def]
    pass


@njit(cache=True)
def _no_slope(x, u, p, out):  # type: ignore[no-untyped-def]
    pass
