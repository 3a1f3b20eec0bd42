"""What an input is to the circuit that it drives: volts, or a reference that a servo loop makes volts of."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel
from symdyn.numeric.filtering.signals import Signals
from symdyn.numeric.gearing import joint_name

Array = NDArray[np.float64]

QUANTILES = (0.98, 0.9, 0.8, 0.65, 0.5)  # of the size of a voltage: limits that are tried
SMALL = 1e-3  # of an input
PARTS = np.geomspace(1.0, 0.01, 12)  # of what a loop makes of its whole reference, likewise: it sees the error alone


def per_unit(kernel: Kernel, name: str, size: float, direction: Array) -> float:
    """How much of an unknown force along ``direction`` (np,) does to the machine at rest what a unit of an input does.

    The input is small, of such a ``size``: at nothing at all a dead zone lets nothing through.
    """
    u = np.zeros(len(kernel.inputs))
    u[kernel.inputs.index(name)] = size
    at = np.zeros(len(kernel.states)), u, kernel.values
    by_input = np.asarray(kernel.state_derivative_input_jacobian_p(*at))[:, kernel.inputs.index(name)]
    by_force = np.asarray(kernel.state_derivative_parameter_jacobian_p(*at)) @ direction
    return abs(float(by_input @ by_force / (by_force @ by_force))) if by_force.any() else 1.0


def limits(kernel: Kernel, signals: Signals, circuit: str, push: str) -> Array:
    """Voltages that may be the most which an amplifier gives; the parameter ``push`` adds to that of the circuit."""
    column = next(i for i, name in enumerate(kernel.inputs) if joint_name(name) == joint_name(circuit))
    size = np.abs(signals.u[:, column])
    if not kernel.inputs[column].endswith(".reference") or push not in kernel.parameters:
        return np.asarray(np.quantile(size, QUANTILES))
    most, direction = float(np.max(size)), np.zeros(len(kernel.parameters))
    direction[kernel.parameters.index(push)] = 1.0
    return np.asarray(PARTS * most * per_unit(kernel, kernel.inputs[column], SMALL * most, direction))
