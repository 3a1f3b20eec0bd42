"""Simulation of the full drive model: the emitted state derivative and Jacobian under a stiff solver."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import integrate

from symdyn.base.errors import InputError, NumericalError, Problem
from symdyn.emit.kernel import Kernel

Array = NDArray[np.float64]
Progress = Callable[[float], None]


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """``time`` (N,), ``states`` (N, nx) in the kernel's order, ``inputs`` (N, nu), ``outputs`` (N, ny)."""

    time: Array
    states: Array
    inputs: Array
    outputs: Array
    names: tuple[str, ...]
    evaluations: int

    def table(self, kernel: Kernel) -> Mapping[str, Array]:
        """Columns by name with units, for a CSV file: "time [s]", "axis1.motor.q [rad]", ..."""
        columns = {"time [s]": self.time}
        groups = (
            (kernel.states, kernel.state_units, self.states),
            (kernel.inputs, kernel.input_units, self.inputs),
            (kernel.outputs, kernel.output_units, self.outputs),
        )
        for names, units, values in groups:
            for i, (name, unit) in enumerate(zip(names, units, strict=True)):
                columns[f"{name} [{unit}]"] = values[:, i]
        return columns


def simulate(
    kernel: Kernel,
    time: Array,
    inputs: Callable[[float], Array] | None = None,
    *,
    start: Array | None = None,
    tolerance: float = 1e-8,
    progress: Progress = lambda _: None,
) -> Trajectory:
    """Integrate from ``time[0]`` to ``time[-1]`` and report at every time.

    ``inputs(t)`` (nu,) defaults to zero, ``start`` (nx,) to rest at the origin. Radau IIA of order 5
    with the kernel's exact Jacobian. A kernel with jumps (friction, backlash) must have been compiled
    with a smoothing width: events are not located here.

    Raises InputError (SD302) for a bad time or start, NumericalError (SD303) with the time reached
    and the fastest state when the solver gives up.
    """
    _check_times(time)
    x0 = np.zeros(len(kernel.states)) if start is None else np.asarray(start, dtype=np.float64)
    if x0.shape != (len(kernel.states),) or not np.all(np.isfinite(x0)):
        raise InputError(Problem("SD302", f"the start state needs {len(kernel.states)} finite numbers"))
    control = inputs if inputs is not None else lambda _: np.zeros(len(kernel.inputs))

    def rate(t: float, x: Array) -> Array:
        progress(t)
        return np.asarray(kernel.state_derivative(x, control(t)))

    def jacobian(t: float, x: Array) -> Array:
        return np.asarray(kernel.state_derivative_state_jacobian(x, control(t)))

    span, finest = (time[0], time[-1]), tolerance * 1e-2
    try:
        solution = integrate.solve_ivp(
            rate, span, x0, method="Radau", jac=jacobian, t_eval=time, rtol=tolerance, atol=finest
        )
    except ValueError as error:  # linear algebra on numbers that are not finite any more
        hint = "the model is unstable, or too stiff for the tolerance"
        raise NumericalError(Problem("SD303", f"the simulation left the finite numbers: {error}", hint=hint)) from None
    if not solution.success or not np.all(np.isfinite(solution.y)):
        reached = float(solution.t[-1]) if len(solution.t) else float(time[0])
        last = solution.y[:, -1] if solution.y.size else x0
        fastest = kernel.states[int(np.argmax(np.abs(rate(reached, last))))]
        raise NumericalError(
            Problem(
                "SD303",
                f"the simulation stopped at t = {reached:.6g} s: {solution.message}",
                hint=f"fastest state: {fastest}; a jump there needs a wider smoothing, or the model is unstable",
            )
        )
    states = np.ascontiguousarray(solution.y.T)
    drive = np.array([control(t) for t in time]).reshape(len(time), -1)
    outputs = kernel.rows("output", states, drive) if kernel.outputs else np.zeros((len(time), 0))
    return Trajectory(time, states, drive, outputs, kernel.states, int(solution.nfev))


def _check_times(time: Array) -> None:
    if len(time) < 2 or not np.all(np.isfinite(time)) or np.any(np.diff(time) <= 0):
        raise InputError(Problem("SD302", "times must be at least two, finite and increasing"))
