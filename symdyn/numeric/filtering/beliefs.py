"""What is known of parameters before a fit: bounds, and normal priors of them or of their logarithms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Belief:
    """What is known of a parameter beforehand: bounds, and a normal prior (``spread`` inf: none).

    Of a ``positive`` one all of it, but for the bounds, is meant of its logarithm.
    """

    lower: float = -np.inf
    upper: float = np.inf
    centre: float = 0.0
    spread: float = np.inf
    positive: bool = False

    def coordinate(self, value: float) -> float:
        return float(np.log(value)) if self.positive else value

    def value(self, coordinate: float) -> float:
        return float(np.exp(coordinate)) if self.positive else float(np.clip(coordinate, self.lower, self.upper))


Beliefs = Mapping[str, Belief]


def untold(start: float) -> Belief:
    """Of a positive parameter that no data sheet told, about where its fit starts: a factor of ten either way."""
    return Belief(positive=True, centre=float(np.log(start)), spread=float(np.log(10.0)))


def penalty(p: Array, index: Mapping[str, int], beliefs: Beliefs) -> float:
    """What a prior adds to -log L."""
    return sum(0.5 * ((b.coordinate(p[index[n]]) - b.centre) / b.spread) ** 2 for n, b in beliefs.items())
