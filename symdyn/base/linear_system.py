"""A linear model as arrays with names and units: what crosses from symbols to numbers beside the kernel."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Element:
    """One effect at its place: what it stores and loses for its own displacement, ``lever`` (n,) times coordinates.

    ``inertia``, ``stiffness`` and ``damping`` are those of the linear model, in SI units along the place.
    """

    address: str
    title: str
    lever: Array
    inertia: float
    stiffness: float
    damping: float


@dataclass(frozen=True, slots=True, eq=False)
class LinearSystem:
    """``e dx/dt = f x + h u``, ``y = c x + d u`` for small deviations from an operating point.

    The state is [coordinates (n), their rates (n), hidden states]. Rows of the coordinates' rates are
    the equations of motion, not divided by inertias: ``e`` holds the mass matrix, and stays finite where
    an inertia or an inductance goes to zero. ``drift`` (nx,) is dx/dt at the operating point: zero where it is an
    equilibrium.
    """

    name: str
    e: Array
    f: Array
    h: Array
    c: Array
    d: Array
    coordinates: tuple[str, ...]
    states: tuple[str, ...]
    state_units: tuple[str, ...]
    inputs: tuple[str, ...]
    input_units: tuple[str, ...]
    outputs: tuple[str, ...]
    output_units: tuple[str, ...]
    drift: Array
    elements: tuple[Element, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Derivatives:
    """Exact derivatives of the matrices of a LinearSystem with respect to each parameter, the first axis."""

    e: Array
    f: Array
    h: Array
    c: Array
    d: Array

    @property
    def used(self) -> tuple[bool, ...]:
        """Of each parameter, whether the linear model has it at all."""
        parts = (self.e, self.f, self.h, self.c, self.d)
        return tuple(any(bool(part[k].any()) for part in parts) for k in range(len(self.f)))


@dataclass(frozen=True, slots=True, eq=False)
class LinearFamily:
    """The linear models of one machine at one operating point, over its parameters.

    ``at(p)`` is the model with other parameter values (np,), ``derivatives(p)`` its derivatives there; both raise
    NumericalError (SD610) where the equations have no finite coefficients.
    """

    name: str
    parameters: tuple[str, ...]
    units: tuple[str, ...]
    meanings: tuple[str, ...]
    values: Array
    at: Callable[[Array], LinearSystem]
    derivatives: Callable[[Array], Derivatives]

    @property
    def nominal(self) -> LinearSystem:
        return self.at(self.values)

    def index(self, parameter: str) -> int:
        """Raises KeyError for a name that is no parameter."""
        if parameter not in self.parameters:
            raise KeyError(parameter)
        return self.parameters.index(parameter)
