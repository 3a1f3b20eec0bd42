"""One parameter at a time, by factors: what becomes of the modes and of the frequency response (seed fig. 12)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from symdyn.base.linear_system import Array, LinearFamily
from symdyn.numeric.linear.eigen import poles
from symdyn.numeric.linear.resolvent import Complex
from symdyn.numeric.linear.response import Response, frequency_response

FACTORS = (0.5, 2.0)


@dataclass(frozen=True, slots=True, eq=False)
class Variation:
    """The machine with one parameter times ``factor``.

    ``poles`` (modes,) are in the order of the nominal ones (NaN where one has no counterpart); ``response`` is over
    the same frequencies as the nominal one.
    """

    parameter: str
    factor: float
    poles: Complex
    response: Response


@dataclass(frozen=True, slots=True, eq=False)
class OneAtATime:
    """All variations, and the nominal machine."""

    nominal: Response
    poles: Complex
    variations: tuple[Variation, ...]

    def deviation(self, variation: Variation) -> Array:
        """(N,) change of the magnitude in dB."""
        return variation.response.decibel - self.nominal.decibel


def one_at_a_time(
    family: LinearFamily,
    hertz: NDArray[np.float64],
    input: str | None = None,
    output: str | None = None,
    parameters: Sequence[str] | None = None,
    factors: Sequence[float] = FACTORS,
    progress: Callable[[str], None] = lambda _: None,
) -> OneAtATime:
    """Every parameter (or those named) times each factor. One whose value is 0 does not change, and is left out.

    UsageError (SD305) for an unknown input or output; KeyError for an unknown parameter.
    """
    names = family.parameters if parameters is None else tuple(parameters)
    nominal = family.nominal
    reference = poles(nominal).values
    found = []
    for name in names:
        k = family.index(name)
        if family.values[k] == 0.0:
            continue
        progress(f"step {name} varied")
        for factor in factors:
            values = family.values.copy()
            values[k] *= factor
            system = family.at(values)
            response = frequency_response(system, hertz, input, output)
            found.append(Variation(name, float(factor), matched(reference, poles(system).values), response))
    return OneAtATime(frequency_response(nominal, hertz, input, output), reference, tuple(found))


def matched(reference: Complex, moved: Complex) -> Complex:
    """``moved`` in the order of ``reference``, paired at least relative distance; NaN where there is no partner."""
    size = np.abs(reference)[:, None] + np.abs(moved)[None, :]
    distance = np.abs(reference[:, None] - moved[None, :]) / np.where(size > 0, size, 1.0)
    found = np.full(len(reference), np.nan, np.complex128)
    for i, j in zip(*optimize.linear_sum_assignment(distance), strict=True):
        found[i] = moved[j]
    return found
