"""A model, part of it measured, under a Kalman filter: whitened innovations and how they change with parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel
from symdyn.numeric.filtering.balance import Balance, balance
from symdyn.numeric.filtering.between import Between, matters, nodes
from symdyn.numeric.filtering.budget import spend
from symdyn.numeric.filtering.gears import BASELINE
from symdyn.numeric.filtering.kalman import run
from symdyn.numeric.filtering.signals import Signals, opening

Array = NDArray[np.float64]
Driven = tuple[Array, Array, Array, Array]  # inputs, their slopes, steps, and how far parameters go along in each

DEAF = 1e30  # variance of a measurement that a filter does not listen to
SHIFT = 0.05  # of a step, for the difference quotient of a delay
TOO_LITTLE = 0.05  # nats that a step of a fit promises: less is not worth a run of the filter
FASTEST = 0.5  # decay of a latent force, per sample: faster is all but white noise
WHITE = 3.0  # the same of what an input's samples are off by, each for itself
SWINGS = 2.0  # periods of a part that is not measured, after which those that are have told where it is
CLOSE = 0.1  # of what is unknown of a start: two that are closer are one
BENT = 1e-2  # of the travel: what a hidden displacement may be at the start


@dataclass(frozen=True, slots=True, eq=False)
class Noise:
    """Variances ``r`` (m,) of the measurements, and latent forces: Ornstein-Uhlenbeck processes.

    ``directions`` (np, l) says along which parameters each force acts, ``decay`` (l,) in 1/s is the inverse of its
    correlation time, ``power`` (l,) its variance, which a fit takes to ``most`` (l,) at most. The first ``inputs`` of
    them are the noise of the inputs and of the equations, which is all but white: rounding, what an input does between
    two samples, what a step of the filter leaves out. ``first`` (inputs,) is the variance that those begin with, and
    ``shown`` (inputs,) the largest one that white noise can have beside what is seen of them.
    """

    r: Array
    directions: Array
    decay: Array
    power: Array
    most: Array
    first: Array = field(default_factory=lambda: np.zeros(0))
    shown: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def inputs(self) -> int:
        return len(self.first)

    @property
    def quiet(self) -> Noise:
        """Without any force but the noise of the inputs and of the equations."""
        k = self.inputs
        decay, power, most = (x[:k].copy() for x in (self.decay, self.power, self.most))
        return Noise(self.r, self.directions[:, :k].copy(), decay, power, most, self.first, self.shown)


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
    """Runs the filter on one recording; parameter vectors are those of the kernel, and the ``delays`` of its inputs."""

    def __init__(
        self,
        kernel: Kernel,
        signals: Signals,
        noise: Noise,
        between: Between = Between.STRAIGHT,
        substeps: int = 1,
        delays: Sequence[str] = (),
    ) -> None:
        """``between``: what an input does over a step.

        ``delays`` names parameters beyond the kernel's: by how much each input comes late, in s. ``settling`` in s is
        how long the states of parts that nobody measures are a guess.
        """
        self.kernel, self.signals, self.noise = kernel, signals, noise
        self.between, self.substeps, self.delays = between, substeps, tuple(delays)
        self.index = {name: i for i, name in enumerate((*kernel.parameters, *delays))}
        self._start, self._spread, slowest, self._balance = _start(kernel, signals)
        self.settling = max(BASELINE, SWINGS * 2.0 * np.pi / slowest) if slowest else BASELINE
        self._moment = min(len(signals.y), round(self.settling / float(np.nanmedian(signals.steps))))
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
        return FilterBench(self.kernel, self.signals, noise, self.between, self.substeps, self.delays)

    def with_inputs(self, between: Between) -> FilterBench:
        """The same filter, with inputs that do something else between samples."""
        return FilterBench(self.kernel, self.signals, self.noise, between, self.substeps, self.delays)

    @property
    def ways(self) -> tuple[Between, ...]:
        """What its inputs may do between samples."""
        banded = matters(self.signals.u, self.signals.steps)
        return tuple(way for way in Between if banded or way is not Between.BANDED)

    def in_steps(self, many: int) -> FilterBench:
        """The same filter, with so many steps in place of one."""
        return FilterBench(self.kernel, self.signals, self.noise, self.between, many * self.substeps, self.delays)

    def filtered(self, p: Array, names: Sequence[str] = (), weight: Array | None = None) -> Pass:
        """The filter at parameters ``p`` (np + delays,), differentiated by those named.

        ``weight`` (N, q): how far each of them goes along in the step after each sample; all the way, if None.
        """
        late = [name in self.delays for name in names]
        which = [self.index[name] for name, delay in zip(names, late, strict=True) if not delay]
        (done,) = self._run(p, [self.noise], which, weight)
        return done if not any(late) else replace(done, slopes=self._with_delays(p, names, late, done))

    def beside(self, p: Array, noises: Sequence[Noise]) -> list[Pass]:
        """The filter as it is, then with other noise, nearly the same: those runs share its steps and Jacobians.

        They cost a third of their own runs or less. States are those of the first in all of them.
        """
        return self._run(p, [self.noise, *noises], [], None)

    def _run(self, p: Array, noises: Sequence[Noise], which: Sequence[int], weight: Array | None) -> list[Pass]:
        own, u, slope, steps, parts = self._driven(p)
        whole = np.ones((len(steps) // parts, len(which))) if weight is None else weight
        driven = u, slope, steps, np.ascontiguousarray(np.repeat(whole, parts, axis=0))
        return self._from(self._begin(own, driven, parts), own, driven, parts, noises, which)

    def _begin(self, own: Array, driven: Driven, parts: int) -> Array:
        """(n,) the state at the start: hidden parts in balance, or unbent, whichever the first moment is likelier from.

        A machine at rest is in balance, and so is one in motion; a simulation may begin with nothing bent.
        """
        sets, holds = self.signals.sets(own, self.index)
        balanced, count = self._balance.found(sets[holds[0]], self._start), max(2, self._moment) * parts
        if np.all(np.abs(balanced - self._start) < CLOSE * np.sqrt(np.diag(self._spread))):
            return balanced
        u, slope, steps, whole = (x[:count] for x in driven)
        first = u, slope, steps, np.ascontiguousarray(whole[:, :0])
        ways = [(self._from(x, own, first, parts, [self.noise], [])[0].loss, x) for x in (balanced, self._start)]
        return ways[0][1] if ways[0][0] <= ways[1][0] else ways[1][1]

    def _from(
        self, start: Array, own: Array, driven: Driven, parts: int, noises: Sequence[Noise], which: Sequence[int]
    ) -> list[Pass]:
        u, slope, steps, whole = driven
        s, first, rows, filters = self.signals, noises[0], len(steps), len(noises)
        y = s.y[: rows // parts]
        m, n = y.shape[1], len(self.kernel.states)
        loss, e, variances = np.zeros(filters), np.zeros((filters, rows, m)), np.ones((filters, rows, m))
        slopes, states = np.zeros((rows, m, len(which))), np.zeros((rows, n + len(first.decay)))
        r, decay, power = (np.stack([getattr(each, of) for each in noises]) for of in ("r", "decay", "power"))
        sets, holds = s.sets(own, self.index)
        taken = run(
            *self._rates, *self._outputs, u, slope, _between(y, parts), steps, sets,
            np.repeat(holds[: rows // parts], parts), np.array(which, np.int64), whole, r, s.index,
            np.ascontiguousarray(first.directions), decay, power, start, self._spread, self.substeps,
            len(self.kernel.outputs), loss, e, variances, slopes, states,
        )  # fmt: skip
        size = n + len(first.decay)
        spend(taken * size**2 * (size * (1 + filters) + len(which)))
        loss = np.where(np.isfinite(loss), loss, np.inf)
        return [
            Pass(float(loss[v]), *(values[::parts] for values in (e[v], variances[v], slopes, states)))
            for v in range(filters)
        ]

    def _with_delays(self, p: Array, names: Sequence[str], late: Sequence[bool], done: Pass) -> Array:
        """Sensitivities with those by delays among them, which are difference quotients."""
        found = np.zeros((*done.innovations.shape, len(names)))
        found[:, :, ~np.array(late)] = done.slopes
        moved_by = SHIFT * float(np.nanmedian(self.signals.steps))
        for j, name in enumerate(names):
            if late[j]:
                moved = p.copy()
                moved[self.index[name]] += moved_by
                found[:, :, j] = (self.filtered(moved).innovations - done.innovations) / moved_by
        return found

    def simulated(self, p: Array, start: Array, first: int, stop: int) -> Array:
        """(stop - first, m) what the channels would show from state ``start`` (n,) at sample ``first`` on."""
        s, n, m = self.signals, len(self.kernel.states), self.signals.y.shape[1]
        own, u, slope, steps, parts = self._driven(p)
        here, rows, none = slice(first * parts, stop * parts), (stop - first) * parts, np.zeros((1, 0))
        e, variances, slopes = np.zeros((1, rows, m)), np.ones((1, rows, m)), np.zeros((rows, m, 0))
        sets, holds = s.sets(own, self.index)
        taken = run(
            *self._rates, *self._outputs, u[here], slope[here], _between(np.zeros((stop - first, m)), parts),
            steps[here], sets, np.repeat(holds[first:stop], parts), np.zeros(0, dtype=np.int64), np.zeros((rows, 0)),
            np.full((1, m), DEAF), s.index, np.zeros((len(own), 0)), none, none, start, np.zeros((n, n)),
            self.substeps, len(self.kernel.outputs), np.zeros(1), e, variances, slopes, np.zeros((rows, n)),
        )  # fmt: skip
        spend(taken * n**3)
        return -e[0, ::parts]  # of measurements that are zero, and move nothing

    def _driven(self, p: Array) -> tuple[Array, Array, Array, Array, int]:
        """The kernel's own parameters; inputs, their slopes and steps; into how many parts steps are cut.

        An input that is held and comes late by more than whole steps jumps within each.
        """
        own = np.ascontiguousarray(p[: len(self.kernel.parameters)])
        late = p[len(self.kernel.parameters) :]
        u, steps = self.signals.u.copy(), self.signals.steps
        if self.between is Between.BANDED:
            u = nodes(u, steps)
        usual = float(np.nanmedian(steps))
        rest = np.zeros(u.shape[1])
        for j, delay in enumerate(late):
            whole = int(delay / usual)
            rest[j] = delay / usual - whole
            u[:, j] = u[np.maximum(np.arange(len(u)) - whole, 0), j]
        before = np.vstack([u[:1], u[:-1]])
        if self.between is not Between.HELD:
            u += rest * (before - u)
            slope = np.zeros_like(u)
            slope[:-1] = np.nan_to_num(np.diff(u, axis=0) / steps[:-1, None])
            return own, u, slope, steps, 1
        ends = np.unique(np.append(rest[rest > 0.0], 1.0))
        cut = [np.where(rest >= end, before, u) for end in ends]
        parts = np.diff(ends, prepend=0.0)
        many = np.stack(cut, axis=1).reshape(-1, u.shape[1])
        return own, many, np.zeros_like(many), (steps[:, None] * parts).ravel(), len(ends)

    def residual(self, p: Array) -> Array:
        """(N, m) whitened innovations."""
        return self.filtered(p).white

    def columns(self, p: Array, names: Sequence[str]) -> Array:
        """(N, m, k) what a parameter takes off the whitened innovations, per unit."""
        done = self.filtered(p, names)
        return -done.slopes / np.sqrt(done.variances)[:, :, None]


def _between(y: Array, parts: int) -> Array:
    """Nothing is measured between two samples."""
    if parts == 1:
        return y
    wide = np.full((len(y), parts, y.shape[1]), np.nan)
    wide[:, 0] = y
    return wide.reshape(-1, y.shape[1])


def _start(kernel: Kernel, signals: Signals) -> tuple[Array, Array, float, Balance]:
    """(n,) state before the first sample and its covariance (n, n): what is measured, else rest with room around it.

    Then the frequency (rad/s) of the slowest swing that is not measured, 0 where there is none, and where parts that
    are not measured are in balance.

    The parts of one drive move together, geared, but for a twist. A speed that only a position tells begins as it does:
    linearised at rest, dry friction would hold what moves, and the filter would believe it.
    """
    n, coordinates = len(kernel.states), len(kernel.coordinates)
    x, cov = np.zeros(n), np.zeros((n, n))
    turns, other = signals.per_joint, 1.0
    joints = np.array([name.partition(".")[0] for name in kernel.coordinates])
    speed, travel = np.abs(signals.speeds / turns), np.zeros(coordinates)  # of the joints
    for c, index in enumerate(signals.index):
        values = signals.y[:, c]
        if index < n:
            x[index] = values[0]
        if index < coordinates:
            together = joints == joints[index]
            travel[together] = np.maximum(travel[together], abs(float(np.ptp(values)) / turns[index]))
        elif 2 * coordinates <= index < n:
            other = max(other, float(np.ptp(values)))
    measured = {int(i) for i in signals.index}
    for c, index in enumerate(signals.index):
        if index < coordinates and coordinates + index not in measured:
            x[coordinates + index] = opening(signals, signals.y[:, c], BASELINE)[0]
            measured.add(coordinates + int(index))
    travel = np.where(travel > 0.0, travel, speed * len(signals.y) * float(np.nanmedian(signals.steps)))
    for first in (0, coordinates):
        for i in range(coordinates):
            known = [j for j in np.flatnonzero(joints == joints[i]) if first + j in measured]
            if known and first + i not in measured:
                x[first + i] = x[first + known[0]] * turns[i] / turns[known[0]]
    hidden = [i for i in range(coordinates) if i not in measured]
    bend, rate = _bends(kernel, x, signals.u[0], hidden, speed, travel)
    for first, size, apart, more in (
        (0, 1e-2 * travel, 1e-4 * travel, bend),
        (coordinates, speed, 1e-2 * speed, rate * bend),
    ):
        for i in range(coordinates):
            for j in np.flatnonzero(joints == joints[i]):
                cov[first + i, first + j] = turns[i] * turns[j] * size[i] ** 2
            cov[first + i, first + i] += max(abs(turns[i]) * apart[i], more[i]) ** 2
    bent = BENT * float(travel.max())
    for i in range(2 * coordinates, n):
        cov[i, i] = {"1": 1.0, "rad": bent, "m": bent}.get(kernel.state_units[i], other) ** 2
    slowest = min((float(each) for each in rate if each > 0.0), default=0.0)
    return x, cov, slowest, balance(kernel, signals, hidden, bend, turns)


def _bends(
    kernel: Kernel, x: Array, u: Array, hidden: Sequence[int], speed: Array, travel: Array
) -> tuple[Array, Array]:
    """(c,) how far hidden coordinates may be from where nothing is bent, and the frequencies at which they swing there.

    What accelerates them there (weight, an input, the motion itself), over what a bent shaft does.
    """
    n, p = len(kernel.coordinates), kernel.values
    bend, frequency = np.zeros(n), np.zeros(n)
    pushed = np.abs(kernel.state_derivative_p(x, u, p)[n : 2 * n])
    back = -np.diag(kernel.state_derivative_state_jacobian_p(x, u, p)[n : 2 * n, :n])
    for i in hidden:
        if back[i] > 0.0 and travel[i] > 0.0:
            bend[i], frequency[i] = (pushed[i] + speed[i] ** 2 / travel[i]) / back[i], np.sqrt(back[i])
    return bend, frequency


@njit(cache=True)
def _nothing(x, u, p, out):  # type: ignore[no-untyped-def]
    pass


@njit(cache=True)
def _no_slope(x, u, p, out):  # type: ignore[no-untyped-def]
    pass
