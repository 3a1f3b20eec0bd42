"""Linear models at an operating point as python-control systems; modes and peaks with their numbers."""

from __future__ import annotations

from dataclasses import dataclass

import control
import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from symdyn.emit.kernel import Kernel

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Mode:
    """A pole: natural frequency in Hz and damping ratio (a real pole has |zeta| = 1, the origin 0 Hz)."""

    pole: complex
    frequency: float
    damping: float


@dataclass(frozen=True, slots=True)
class Extremum:
    """A local maximum or minimum of a frequency response's magnitude."""

    frequency: float  # Hz
    magnitude: float
    kind: str  # "peak" or "anti-resonance"


def linear_model(kernel: Kernel, x: Array | None = None, u: Array | None = None) -> control.StateSpace:
    """A, B, C, D of the kernel at state ``x`` (nx,) and input ``u`` (nu,), both zero by default.

    Signals carry the kernel's names with dots written as underscores (python-control's rule). A
    robot without sensors shows its whole state.
    """
    x = np.zeros(len(kernel.states)) if x is None else x
    u = np.zeros(len(kernel.inputs)) if u is None else u
    a = kernel.state_derivative_state_jacobian(x, u)
    b = kernel.state_derivative_input_jacobian(x, u)
    if kernel.outputs:
        c, d = kernel.output_state_jacobian(x, u), kernel.output_input_jacobian(x, u)
    else:
        c, d = np.eye(len(x)), np.zeros((len(x), len(u)))
    plain = [[name.replace(".", "_") for name in names] for names in (kernel.states, kernel.inputs)]
    shown = [name.replace(".", "_") for name in (kernel.outputs or kernel.states)]
    if not kernel.outputs:
        shown = [f"{name}_" for name in shown]
    return control.ss(a, b, c, d, states=plain[0], inputs=plain[1], outputs=shown, name=kernel.module.ROBOT)


def modes(system: control.StateSpace) -> tuple[Mode, ...]:
    """Poles, slowest first; of a conjugate pair the one with positive imaginary part."""
    found = []
    for pole in system.poles():
        if pole.imag < -1e-9 * abs(pole):
            continue
        size = abs(pole)
        zeta = -pole.real / size if size > 1e-6 else 0.0
        found.append(Mode(complex(pole), float(size / (2 * np.pi)), float(zeta)))
    return tuple(sorted(found, key=lambda mode: mode.frequency))


def magnitude(system: control.StateSpace, hertz: Array, output: int = 0, input: int = 0) -> Array:
    """|G(j 2 pi f)| from one input to one output."""
    response = system(2j * np.pi * np.atleast_1d(hertz), squeeze=False)
    return np.asarray(np.abs(response[output, input]))


def extrema(
    system: control.StateSpace, low: float, high: float, output: int = 0, input: int = 0, points: int = 20_000
) -> tuple[Extremum, ...]:
    """Peaks and anti-resonances between two frequencies in Hz, located to solver precision."""
    grid = np.geomspace(low, high, points)
    size = np.log(magnitude(system, grid, output, input))
    slope = np.sign(np.diff(size))
    found = []
    for i in np.flatnonzero(slope[1:] != slope[:-1]) + 1:
        peak = slope[i - 1] > 0
        sense = -1.0 if peak else 1.0
        result = optimize.minimize_scalar(
            lambda f, s=sense: s * float(np.log(magnitude(system, np.array([f]), output, input)[0])),
            bounds=(grid[i - 1], grid[i + 1]), method="bounded", options={"xatol": 1e-9 * grid[i]},
        )  # fmt: skip
        value = float(magnitude(system, np.array([result.x]), output, input)[0])
        found.append(Extremum(float(result.x), value, "peak" if peak else "anti-resonance"))
    return tuple(found)
