"""Frequency response from any input to any sensor or state; its peaks and anti-resonances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from symdyn.base.linear_system import Array, LinearSystem
from symdyn.numeric.linear.resolvent import Complex, Resolvent, laplace
from symdyn.numeric.linear.signals import channel, grid


@dataclass(frozen=True, slots=True, eq=False)
class Response:
    """G(j 2 pi f) of one channel: ``hertz`` (N,), ``values`` (N,) complex, in ``unit``."""

    input: str
    output: str
    unit: str
    hertz: Array
    values: Complex

    @property
    def magnitude(self) -> Array:
        return np.abs(self.values)

    @property
    def decibel(self) -> Array:
        with np.errstate(divide="ignore"):
            return np.asarray(20 * np.log10(np.abs(self.values)), np.float64)

    @property
    def phase(self) -> Array:
        """Degrees, without jumps from point to point."""
        return np.degrees(np.unwrap(np.angle(self.values)))


@dataclass(frozen=True, slots=True)
class Extremum:
    """A local maximum or minimum of a frequency response's magnitude."""

    frequency: float  # Hz
    magnitude: float
    kind: str  # "peak" or "anti-resonance"


def frequency_response(
    system: LinearSystem, hertz: NDArray[np.float64], input: str | None = None, output: str | None = None
) -> Response:
    """At frequencies ``hertz`` (N,); UsageError (SD305) for an unknown name. Infinite exactly at a pole."""
    chosen = channel(system, input, output)
    f = np.atleast_1d(np.asarray(hertz, np.float64))
    values = Resolvent.of(system).apply(laplace(f), chosen.row, system.h[:, chosen.k]) + chosen.feed
    return Response(chosen.input, chosen.output, chosen.unit, f, values)


def extrema(
    system: LinearSystem,
    low: float,
    high: float,
    input: str | None = None,
    output: str | None = None,
    points: int = 4000,
) -> tuple[Extremum, ...]:
    """Peaks and anti-resonances between two frequencies in Hz, found on a grid and located to 1e-9 of themselves."""
    chosen, resolvent = channel(system, input, output), Resolvent.of(system)
    column = system.h[:, chosen.k]

    def size(hertz: NDArray[np.float64]) -> Array:
        values = resolvent.apply(laplace(hertz), chosen.row, column) + chosen.feed
        with np.errstate(divide="ignore"):
            return np.log(np.abs(values))

    hertz = grid(low, high, points)
    slope = np.sign(np.diff(size(hertz)))
    found = []
    for i in np.flatnonzero(slope[1:] * slope[:-1] < 0) + 1:
        sense = -1.0 if slope[i - 1] > 0 else 1.0
        result = optimize.minimize_scalar(
            lambda f, s=sense: s * float(size(np.array([f]))[0]),
            bounds=(hertz[i - 1], hertz[i + 1]), method="bounded", options={"xatol": 1e-9 * hertz[i]},
        )  # fmt: skip
        kind = "peak" if sense < 0 else "anti-resonance"
        found.append(Extremum(float(result.x), float(np.exp(sense * result.fun)), kind))
    return tuple(found)
