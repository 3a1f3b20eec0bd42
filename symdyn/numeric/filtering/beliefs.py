"""What is known of parameters before a fit: bounds, and normal priors of them or of their logarithms."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Belief:
    """What is known of a parameter beforehand: bounds, and a normal prior (``spread`` inf: none).

    Of a ``positive`` one all of it, but for the bounds, is meant of its logarithm. It may be ``like`` another positive
    one that is believed in: ``apart`` is the spread of the logarithm of their ratio.
    """

    lower: float = -np.inf
    upper: float = np.inf
    centre: float = 0.0
    spread: float = np.inf
    positive: bool = False
    like: str = ""
    apart: float = np.inf

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
    x = coordinates(p, index, beliefs)
    away = x - _centres(beliefs)
    alone = sum(0.5 * (off / b.spread) ** 2 for off, b in zip(away, beliefs.values(), strict=True))
    return float(alone + sum(0.5 * ((x[i] - x[j]) / apart) ** 2 for i, j, apart in _pairs(beliefs)))


def pull(p: Array, index: Mapping[str, int], beliefs: Beliefs) -> Array:
    """(k,) how the penalty falls with each coordinate."""
    x = coordinates(p, index, beliefs)
    found = (_centres(beliefs) - x) / _spreads(beliefs) ** 2
    for i, j, apart in _pairs(beliefs):
        found[i] += (x[j] - x[i]) / apart**2
        found[j] += (x[i] - x[j]) / apart**2
    return np.asarray(found)


def precision(beliefs: Beliefs) -> Array:
    """(k, k) curvature of the penalty."""
    found = np.diag(_spreads(beliefs) ** -2.0)
    for i, j, apart in _pairs(beliefs):
        found[[i, j], [i, j]] += apart**-2.0
        found[[i, j], [j, i]] -= apart**-2.0
    return found


def coordinates(p: Array, index: Mapping[str, int], beliefs: Beliefs) -> Array:
    """(k,) where parameters stand, as they are believed in."""
    return np.array([b.coordinate(p[index[name]]) for name, b in beliefs.items()])


def per_coordinate(values: Array, beliefs: Iterable[Belief]) -> Array:
    """(k,) how ``values`` (k,) change with their coordinates: by themselves, where those are logarithms."""
    return np.array([value if b.positive else 1.0 for value, b in zip(values, beliefs, strict=True)])


def _centres(beliefs: Beliefs) -> Array:
    return np.array([b.centre for b in beliefs.values()])


def _spreads(beliefs: Beliefs) -> Array:
    return np.array([b.spread for b in beliefs.values()])


def _pairs(beliefs: Beliefs) -> list[tuple[int, int, float]]:
    """Of those that are like one another; what a fit does not move is like nothing."""
    at = {name: i for i, name in enumerate(beliefs)}
    return [(at[name], at[b.like], b.apart) for name, b in beliefs.items() if b.like in at]
