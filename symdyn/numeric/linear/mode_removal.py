"""States taken away from a linear model: single modes, or by balancing; each order with its error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from symdyn.base.linear_system import Array, LinearSystem
from symdyn.numeric.linear.cost import Band, Cost, cost
from symdyn.numeric.linear.eigen import poles
from symdyn.numeric.linear.modes import modes
from symdyn.numeric.linear.resolvent import Complex, laplace
from symdyn.numeric.linear.response import frequency_response
from symdyn.numeric.linear.signals import channel

_SEEN = 1e-8  # of the largest response: what such poles give less of is rounding
_SLOW = 1e-9  # of the largest rate: poles nearer to the imaginary axis, or right of it, are kept as they are


@dataclass(frozen=True, slots=True)
class ModeRemoval:
    """A mode replaced by its static share (what it gives to a slow input): its name, pole, states and cost."""

    name: str
    pole: complex
    states: int
    cost: Cost


@dataclass(frozen=True, slots=True)
class BalancedOrder:
    """``order`` states kept: by truncation (exact at high frequency), by residualisation (exact at rest).

    ``hankel`` is the first Hankel singular value that went (Moore 1981); twice the sum of those gone bounds the error.
    """

    order: int
    hankel: float
    truncated: Cost
    residualised: Cost


def mode_removals(
    system: LinearSystem, band: Band, input: str | None = None, output: str | None = None
) -> tuple[ModeRemoval, ...]:
    """The cost of each mode alone; poles at the origin and those that meet others are left out."""
    hertz = band.hertz()
    chosen = channel(system, input, output)
    exact = frequency_response(system, hertz, input, output).values
    found = poles(system)
    residues = (chosen.row @ found.right) * (found.left.conj().T @ system.h[:, chosen.k])
    s = laplace(hertz)
    rows = []
    for mode, pole, residue, meets in zip(modes(system, found), found.values, residues, found.defective, strict=True):
        if pole == 0 or meets:
            continue
        gone = residue / (s - pole) + residue / pole
        if pole.imag > 0:
            gone = gone + np.conj(residue) / (s - np.conj(pole)) + np.conj(residue / pole)
        left = cost(band, hertz, exact, exact - gone)
        rows.append(ModeRemoval(mode.name, complex(pole), 2 if pole.imag > 0 else 1, left))
    return tuple(rows)


def balanced_orders(
    system: LinearSystem, band: Band, input: str | None = None, output: str | None = None
) -> tuple[BalancedOrder, ...]:
    """The channel's model at every lower order, highest first; empty where ``e`` is singular.

    Poles that do not decay are kept exactly and count where they can be seen; the rest is balanced by the square-root
    method (Laub et al. 1987).
    """
    chosen = channel(system, input, output)
    hertz = band.hertz()
    exact = frequency_response(system, hertz, input, output).values
    s = laplace(hertz)
    try:
        a, b = np.linalg.solve(system.e, system.f), np.linalg.solve(system.e, system.h[:, chosen.k])
    except np.linalg.LinAlgError:
        return ()
    a, (scale, _) = linalg.matrix_balance(a, permute=False, separate=True)
    slow, fast = _split(a, b / scale, chosen.row * scale)
    kept = _simulated(s, *slow) + chosen.feed
    own = len(slow[0]) if np.abs(kept - chosen.feed).max() > _SEEN * np.abs(exact).max() else 0
    hankel, (fa, fb, fc) = _balanced(*fast)
    found = []
    for order in range(len(hankel) - 1, -1, -1):
        cut = _simulated(s, fa[:order, :order], fb[:order], fc[:order])
        *rest, static = _residualised(fa, fb, fc, order)
        found.append(
            BalancedOrder(
                own + order,
                float(hankel[order]),
                cost(band, hertz, exact, kept + cut),
                cost(band, hertz, exact, kept + _simulated(s, *rest) + static),
            )
        )
    return tuple(found)


_Siso = tuple[Array, Array, Array]


def _split(a: Array, b: Array, c: Array) -> tuple[_Siso, _Siso]:
    """(what does not decay, what does), decoupled: ordered Schur form and a Sylvester equation."""
    limit = _SLOW * max(float(np.abs(linalg.eigvals(a)).max(initial=0.0)), 1.0)
    t, z, k = linalg.schur(a, sort=lambda re, im: re >= -limit)
    x = linalg.solve_sylvester(t[:k, :k], -t[k:, k:], -t[:k, k:]) if 0 < k < len(a) else np.zeros((k, len(a) - k))
    bz, cz = z.T @ b, c @ z
    return (t[:k, :k], bz[:k] - x @ bz[k:], cz[:k]), (t[k:, k:], bz[k:], cz[k:] + cz[:k] @ x)


def _balanced(a: Array, b: Array, c: Array) -> tuple[Array, _Siso]:
    """Hankel singular values, largest first, and the balanced system without states that nothing reaches or shows."""
    if not len(a):
        return np.zeros(0), (a, b, c)
    reach = _factor(linalg.solve_continuous_lyapunov(a, -np.outer(b, b)))
    show = _factor(linalg.solve_continuous_lyapunov(a.T, -np.outer(c, c)))
    left, hankel, right = linalg.svd(show.T @ reach)
    size = int(np.count_nonzero(hankel > 1e-12 * hankel[:1].max(initial=np.finfo(float).tiny)))
    root = np.sqrt(hankel[:size])
    forth, back = reach @ right[:size].T / root, (show @ left[:, :size] / root).T
    return hankel[:size], (back @ a @ forth, back @ b, c @ forth)


def _factor(gramian: NDArray[np.floating]) -> Array:
    """L with L L^T = the gramian, whose rounding may have left it slightly indefinite."""
    values, vectors = np.linalg.eigh((gramian + gramian.T) / 2)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)), np.float64)


def _residualised(a: Array, b: Array, c: Array, order: int) -> tuple[Array, Array, Array, float]:
    """Singular perturbation: the states behind ``order`` follow at once."""
    r = order
    over = np.linalg.solve(a[r:, r:], np.column_stack([a[r:, :r], b[r:]]))
    return (
        a[:r, :r] - a[:r, r:] @ over[:, :r],
        b[:r] - a[:r, r:] @ over[:, r],
        c[:r] - c[r:] @ over[:, :r],
        -float(c[r:] @ over[:, r]),
    )


def _simulated(s: Complex, a: Array, b: Array, c: Array) -> Complex:
    if not len(a):
        return np.zeros(len(s), np.complex128)
    matrices = s[:, None, None] * np.eye(len(a)) - a
    return np.asarray(np.linalg.solve(matrices, np.broadcast_to(b[:, None], (len(s), len(b), 1)))[:, :, 0] @ c)
