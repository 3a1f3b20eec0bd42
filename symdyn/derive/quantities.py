"""Numbers of a robot as SymPy expressions in its parameter symbols."""

from __future__ import annotations

from collections.abc import Iterable

import sympy as sp

from symdyn.base import symbols
from symdyn.physics.effect import Effect, Values
from symdyn.spec.records import Monomial


def expression(monomial: Monomial) -> sp.Expr:
    """``coefficient * product(parameter ** power)``."""
    return sp.Mul(
        symbols.number(monomial.coefficient),
        *(symbols.parameter(name) ** power for name, power in monomial.factors),
    )


def angle_expression(monomial: Monomial) -> sp.Expr:
    """The same for an angle: plain numbers become exact multiples of pi where they are."""
    return expression(monomial) if monomial.factors else symbols.angle(monomial.coefficient)


def effect_values(effect: Effect, given: Iterable[tuple[str, Monomial]]) -> Values:
    """The parameters of an effect, those that are not given at their defaults."""
    values = {p.name: symbols.number(p.default) for p in effect.parameters if p.default is not None}
    return values | {name: expression(value) for name, value in given}
