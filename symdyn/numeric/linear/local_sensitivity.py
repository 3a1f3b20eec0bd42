"""Exact local sensitivities: how poles and the frequency response move with every parameter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.base.linear_system import Array, Derivatives, LinearFamily, LinearSystem
from symdyn.numeric.linear.eigen import pole_derivatives, poles
from symdyn.numeric.linear.modes import Mode, modes
from symdyn.numeric.linear.resolvent import Complex, Resolvent, laplace
from symdyn.numeric.linear.response import Response
from symdyn.numeric.linear.signals import Channel, channel, channel_derivatives


@dataclass(frozen=True, slots=True, eq=False)
class LocalSensitivity:
    """Derivatives at the nominal parameters, per unit of each parameter; ``*_log`` per relative change of it.

    ``response_gradient`` (np, N) complex is dG/dp; ``pole_gradient`` (np, modes) complex is NaN where poles meet.
    """

    parameters: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    response: Response
    response_gradient: Complex
    modes: tuple[Mode, ...]
    pole_gradient: Complex

    @property
    def magnitude_log(self) -> Array:
        """(np, N): d ln|G| / d ln p; 1 means that 1 % more of the parameter gives 1 % more output."""
        return np.real(self._relative)

    @property
    def phase_log(self) -> Array:
        """(np, N): d arg G / d ln p in rad."""
        return np.imag(self._relative)

    @property
    def frequency_log(self) -> Array:
        """(np, modes): d ln|pole| / d ln p; NaN for a pole at the origin."""
        return np.real(self._relative_poles)

    @property
    def damping_log(self) -> Array:
        """(np, modes): d damping ratio / d ln p (the ratio itself is without a unit); NaN at the origin."""
        pole = np.array([mode.pole for mode in self.modes])
        size = np.abs(pole)
        with np.errstate(divide="ignore", invalid="ignore"):
            per_unit = -self.pole_gradient.real / size + pole.real / size * np.real(self.pole_gradient / pole)
        return np.asarray(self.values[:, None] * per_unit, np.float64)

    @property
    def _relative(self) -> Complex:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.values[:, None] * self.response_gradient / self.response.values)

    @property
    def _relative_poles(self) -> Complex:
        pole = np.array([mode.pole for mode in self.modes])
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.values[:, None] * self.pole_gradient / pole)


def local_sensitivity(
    family: LinearFamily, hertz: NDArray[np.float64], input: str | None = None, output: str | None = None
) -> LocalSensitivity:
    """At frequencies ``hertz`` (N,); UsageError (SD305) for an unknown name."""
    system, derivatives = family.nominal, family.derivatives(family.values)
    chosen = channel(system, input, output)
    f = np.asarray(hertz, np.float64)
    values, gradient = response_gradient(system, derivatives, chosen, f)
    found = poles(system)
    return LocalSensitivity(
        parameters=family.parameters,
        units=family.units,
        values=family.values,
        response=Response(chosen.input, chosen.output, chosen.unit, f, values),
        response_gradient=gradient,
        modes=modes(system, found),
        pole_gradient=pole_derivatives(found, derivatives),
    )


def response_gradient(system: LinearSystem, d: Derivatives, chosen: Channel, hertz: Array) -> tuple[Complex, Complex]:
    """G (N,) and dG/dp (np, N): with x = (sE - F)^-1 h and y = c (sE - F)^-1, dG = y (dF - s dE) x + y dh + dc x."""
    s = laplace(hertz)
    resolvent = Resolvent.of(system)
    x = resolvent.right(s, system.h[:, chosen.k])
    y = resolvent.left(s, chosen.row)
    d_row, d_feed = channel_derivatives(chosen, d)
    gradient = np.zeros((len(d.f), len(s)), np.complex128)
    for p, total in enumerate(gradient):
        total += d_feed[p]
        for i, j in np.argwhere((d.f[p] != 0) | (d.e[p] != 0)):  # few entries hold a parameter
            total += y[i] * (d.f[p, i, j] - s * d.e[p, i, j]) * x[j]
        for i in np.flatnonzero(d.h[p, :, chosen.k]):
            total += d.h[p, i, chosen.k] * y[i]
        for j in np.flatnonzero(d_row[p]):
            total += d_row[p, j] * x[j]
    values = np.einsum("i,ij->j", chosen.row, x) + chosen.feed
    return values, gradient
