"""Exact comparison of expressions: intermediates put back, and a normal form that decides trigonometric identities."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from symdyn.derive.equations import EquationsOfMotion
from symdyn.derive.steps import Step


def substituted(steps: Sequence[Step], outputs: Sequence[sp.Expr]) -> tuple[sp.Expr, ...]:
    """The outputs without intermediates."""
    known: dict[sp.Symbol, sp.Expr] = {}
    for step in steps:
        known[step.symbol] = step.expression.xreplace(known)
    return tuple(sp.sympify(output).xreplace(known) for output in outputs)


def required_efforts(equations: EquationsOfMotion) -> tuple[sp.Expr, ...]:
    """(n,) inverse dynamics in coordinates and parameters alone."""
    return substituted(*equations.required())


def normal_form(expression: sp.Expr) -> sp.Expr:
    """Sums of monomials with no cosine squared: zero exactly when a trigonometric polynomial vanishes."""
    expanded = sp.expand(sp.expand_trig(sp.sympify(expression)))
    return sp.expand(expanded.replace(_is_cosine_power, _without_square))


def _is_cosine_power(e: sp.Basic) -> bool:
    return bool(e.is_Pow and isinstance(e.base, sp.cos) and e.exp.is_Integer and e.exp >= 2)


def _without_square(e: sp.Pow) -> sp.Expr:
    angle, power = e.base.args[0], int(e.exp)
    return (1 - sp.sin(angle) ** 2) ** (power // 2) * sp.cos(angle) ** (power % 2)


def same(first: sp.Expr, second: sp.Expr) -> bool:
    """Whether two expressions are identical as functions."""
    return bool(normal_form(first - second) == 0)
