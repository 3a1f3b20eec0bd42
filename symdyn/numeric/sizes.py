"""How large a model's parameters are, by which a fit measures how far it moves them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.spec.records import Link, Monomial, Robot

Array = NDArray[np.float64]

STRONGEST = 30.0  # m/s^2, three times that of Earth: masses may be given too small


def sizes(robot: Robot) -> dict[str, float]:
    """Of parameters whose own values do not tell it: coordinates of centres of mass, products of inertia, gravity.

    A coordinate is as large as its vector, a product of inertia as its two moments: their values depend on how a frame
    was laid, and what is small or zero in one is none in another. Gravity may be ``STRONGEST`` on every axis.
    """
    values = {p.name: p.value or 0.0 for p in robot.parameters}
    links = [joint.link for joint in robot.joints] + ([robot.tool.link] if robot.tool is not None else [])
    found: dict[str, float] = {}
    told = [(axis, STRONGEST) for axis in robot.gravity]
    for link in links:
        told += [*_coordinates(link, values), *_products(link, values)]
    for monomial, size in told:
        if len(monomial.factors) == 1 and monomial.factors[0][1] == 1 and size > 0.0:
            name = monomial.factors[0][0]
            found[name] = max(found.get(name, 0.0), size / abs(float(monomial.coefficient)))
    return found


def sized(names: Sequence[str], values: Array, known: Mapping[str, float]) -> Array:
    """(k,) the sizes ``known``; of all else its value, and of what is nothing that of the largest."""
    own = np.abs(values)
    rule = np.where(own > 0, own, max(float(own.max(initial=0.0)), 1.0))
    return np.array([known.get(name, size) for name, size in zip(names, rule, strict=True)])


def _coordinates(link: Link, values: Mapping[str, float]) -> list[tuple[Monomial, float]]:
    whole = math.hypot(*(_value(m, values) for m in link.com))
    return [(m, whole) for m in link.com]


def _products(link: Link, values: Mapping[str, float]) -> list[tuple[Monomial, float]]:
    xx, yy, zz = (abs(_value(m, values)) for m in link.inertia[:3])
    return list(zip(link.inertia[3:], (math.sqrt(xx * yy), math.sqrt(xx * zz), math.sqrt(yy * zz)), strict=True))


def _value(monomial: Monomial, values: Mapping[str, float]) -> float:
    return float(monomial.coefficient) * math.prod(values[name] ** power for name, power in monomial.factors)
