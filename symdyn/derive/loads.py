"""The load of a joint: the effort that passes through it, on which the friction there may depend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from symdyn.base import symbols
from symdyn.derive.coordinates import Coordinate
from symdyn.derive.forces import Contribution

ZERO = sp.Integer(0)


@dataclass(frozen=True, slots=True)
class Load:
    """What links, inertias and springs need along coordinate ``axis``; friction resists all the rest.

    As accelerations are given, it is ``needed``. As an effort is, it follows from friction itself (Hamon, Gautier,
    Garrec 2010): load + share |load| = effort + other, with ``other`` what else acts there.
    """

    axis: int
    symbol: sp.Symbol
    needed: sp.Expr
    other: sp.Expr
    share: sp.Expr  # of the load's size that friction takes, against the motion: less than 1 either way

    def size(self, effort: sp.Expr) -> sp.Expr:
        """|load| under an effort along the coordinate: the one solution, because of the share."""
        net = effort + self.other
        return (sp.Abs(net) - self.share * net) / (1 - self.share**2)


def loads(
    contributions: Sequence[Contribution], arm: Sequence[sp.Expr], axes: Sequence[Coordinate]
) -> tuple[Load, ...]:
    """Of the joints where the force of some effect depends on it."""
    found = []
    for k, axis in enumerate(axes):
        symbol = symbols.load(k + 1)
        resisting = [c for c in contributions if c.depends_on(symbol)]
        if not resisting:
            continue
        here = [c for c in contributions if c.attachment.address == axis.address]
        carried = [c for c in here if not c.attachment.effect.dissipative]
        share = -sum((sp.expand(c.applied[k]).coeff(sp.Abs(symbol)) for c in resisting), ZERO)
        needed = arm[k] + sum((c.inertial[k] for c in contributions), ZERO) - sum((c.applied[k] for c in carried), ZERO)
        other = sum((c.applied[k] for c in contributions if c not in (*carried, *resisting)), ZERO)
        found.append(Load(k, symbol, needed, other, share))
    return tuple(found)


def under(efforts: Sequence[sp.Expr], of: Sequence[Load]) -> Mapping[sp.Expr, sp.Expr]:
    """The sizes of loads as functions of the ``efforts`` (n,) along each coordinate, to be put in their place."""
    return {sp.Abs(load.symbol): load.size(efforts[load.axis]) for load in of}
