"""Poles of a linear model with left and right eigenvectors, and the exact derivatives of the poles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import linalg

from symdyn.base.linear_system import Array, Derivatives, LinearSystem
from symdyn.numeric.linear.resolvent import Complex, scales

ILL_CONDITIONED = 1e8  # 1 / |left . right| from which a pole counts as defective: its derivative is infinite


@dataclass(frozen=True, slots=True, eq=False)
class Poles:
    """Finite poles (k,), slowest first; columns of ``right`` and ``left`` (nx, k) with left^H E right = 1.

    Of a conjugate pair the pole with positive imaginary part alone. ``condition`` (k,) is how much larger than a
    change of the (scaled) matrices the change of the pole may be; huge where poles meet and cannot be told apart.
    """

    values: Complex
    right: Complex
    left: Complex
    condition: Array

    @property
    def defective(self) -> list[bool]:
        return [bool(c > ILL_CONDITIONED) for c in self.condition]


def poles(system: LinearSystem) -> Poles:
    """Solves ``f v = pole e v``; infinite poles (of a singular ``e``) are left out, rounding at the origin is zero."""
    rows, columns = scales(system.e, system.f)
    both = np.outer(rows, columns)
    e, f = system.e * both, system.f * both
    solved: Any = linalg.eig(f, e, left=True, right=True, homogeneous_eigvals=True)
    (alpha, beta), left, right = solved
    size = np.finfo(float).eps * len(e)
    finite = np.abs(beta) > size * np.linalg.norm(e)
    values = np.zeros(len(alpha), np.complex128)
    values[finite] = alpha[finite] / beta[finite]
    overlap = np.einsum("ij,ij->j", left.conj(), e @ right)
    weight = np.linalg.norm(left, axis=0) * np.linalg.norm(e @ right, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        condition = np.nan_to_num(weight / np.abs(overlap), nan=np.inf)
        # First order: |change of the pole| <= |change of F| |w| |v| / |w^H E v|, and a root of it where poles meet.
        moved = np.linalg.norm(left, axis=0) * np.linalg.norm(right, axis=0) / np.abs(overlap)
        left = rows[:, None] * left / overlap.conj()
    meeting = np.sqrt(10 * size) * np.linalg.norm(f) / np.linalg.norm(e)
    values[np.abs(values) < np.minimum(10 * size * np.linalg.norm(f) * np.nan_to_num(moved, nan=np.inf), meeting)] = 0.0
    values.imag[np.abs(values.imag) < 1e-10 * np.abs(values)] = 0.0
    kept = [i for i in np.argsort(np.abs(values), kind="stable") if finite[i] and values[i].imag >= 0.0]
    return Poles(values[kept], (columns[:, None] * right)[:, kept], left[:, kept], condition[kept])


def pole_derivatives(found: Poles, d: Derivatives) -> Complex:
    """(np, k): d pole / d parameter = w^H (dF - pole dE) v; NaN for defective poles."""
    moved = np.einsum("ik,pij,jk->pk", found.left.conj(), d.f.astype(np.complex128), found.right, optimize=True)
    moved -= found.values * np.einsum(
        "ik,pij,jk->pk", found.left.conj(), d.e.astype(np.complex128), found.right, optimize=True
    )
    moved[:, found.defective] = np.nan
    return np.asarray(moved, np.complex128)
