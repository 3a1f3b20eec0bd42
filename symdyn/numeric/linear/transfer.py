"""The transfer function of one channel by its zeros, poles and gain."""

from __future__ import annotations

from dataclasses import dataclass

import control
import numpy as np
from scipy import linalg

from symdyn.base.linear_system import LinearSystem
from symdyn.numeric.linear.eigen import poles
from symdyn.numeric.linear.resolvent import Complex, Resolvent, scales
from symdyn.numeric.linear.signals import channel

_SAME = 1e-6  # relative distance at which a zero and a pole cancel
_INFINITE = 1e-11


@dataclass(frozen=True, slots=True, eq=False)
class TransferFunction:
    """G(s) = gain prod(s - zeros) / prod(s - poles), s in 1/s; what the output does not see is cancelled."""

    input: str
    output: str
    unit: str
    zeros: Complex
    poles: Complex
    gain: float

    def as_control(self) -> control.TransferFunction:
        return control.zpk(self.zeros, self.poles, self.gain)


def transfer_function(system: LinearSystem, input: str | None = None, output: str | None = None) -> TransferFunction:
    """Zeros are the finite eigenvalues of Rosenbrock's matrix. UsageError (SD305) for an unknown name."""
    chosen = channel(system, input, output)
    n = len(system.states)
    rows, columns = scales(system.e, system.f)
    column, row = rows * system.h[:, chosen.k], columns * chosen.row
    inner, outer = np.abs(column).max() or 1.0, np.abs(row).max() or 1.0
    both = np.outer(rows, columns)
    f = np.block([[system.f * both, column[:, None] / inner], [row / outer, np.array([[chosen.feed]]) / inner / outer]])
    e = np.zeros((n + 1, n + 1))
    e[:n, :n] = system.e * both
    alpha, beta = linalg.eigvals(f, e, homogeneous_eigvals=True)
    finite = np.abs(beta) > _INFINITE * np.maximum(np.abs(alpha) * 1e-3, np.linalg.norm(e))
    zeros = _paired(alpha[finite] / beta[finite])
    found = poles(system).values
    every = np.concatenate([found, found[found.imag > 0].conj()])
    zeros, every = _cancelled(zeros, every)
    point = np.array([1.1 * (1 + np.abs(np.concatenate([zeros, every, [1.0]])).max())], np.complex128)
    value = Resolvent.of(system).apply(point, chosen.row, system.h[:, chosen.k])[0] + chosen.feed
    gain = value / np.exp(np.log(point - zeros).sum() - np.log(point - every).sum())
    return TransferFunction(chosen.input, chosen.output, chosen.unit, _sorted(zeros), _sorted(every), float(gain.real))


def _paired(values: Complex) -> Complex:
    """Conjugates exactly so, real ones exactly real, which rounding may have spoilt."""
    real = np.abs(values.imag) <= 1e-9 * np.abs(values)
    upper = values[~real & (values.imag > 0)]
    return np.concatenate([values[real].real, upper, upper.conj()])


def _cancelled(zeros: Complex, every: Complex) -> tuple[Complex, Complex]:
    size = float(np.abs(every).max(initial=1.0))
    kept, left = [], list(every)
    for zero in zeros:
        near = [i for i, p in enumerate(left) if abs(p - zero) <= _SAME * max(abs(p), 1e-3 * np.sqrt(size))]
        if near:
            left.pop(min(near, key=lambda i: abs(left[i] - zero)))
        else:
            kept.append(zero)
    return np.array(kept, np.complex128), np.array(left, np.complex128)


def _sorted(values: Complex) -> Complex:
    return values[np.lexsort((values.imag, np.round(np.abs(values), 9)))]
