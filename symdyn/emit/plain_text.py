"""Equations as plain text for a terminal: one line per term, named intermediates on demand."""

from __future__ import annotations

import math
from typing import Any

import sympy as sp

from symdyn.base import symbols
from symdyn.derive import base_parameters as base
from symdyn.derive.equations import EquationsOfMotion
from symdyn.emit import latex
from symdyn.emit.plain_laws import laws
from symdyn.physics import catalogue
from symdyn.spec.effect_schema import ParameterSchema, Scan
from symdyn.spec.records import Robot


class _Text:
    """Prints expressions with parameters under their own names."""

    def __init__(self, robot: Robot) -> None:
        self._names = {symbols.parameter(p.name): sp.Symbol(p.name) for p in robot.parameters}

    def __call__(self, expression: sp.Expr) -> str:
        return str(sp.sstr(expression.xreplace(self._names)))


def equations(of: EquationsOfMotion) -> list[tuple[str, str]]:
    """(place, "left = right") of every coordinate and hidden state."""
    text = _Text(of.robot)
    return [(place, f"{_sum(text, left)} = {_sum(text, right)}") for place, left, right in latex.sides(of)]


def steps(of: EquationsOfMotion) -> list[tuple[str, str, str]]:
    """(symbol, expression, origin) of the Newton-Euler intermediates and of the effects."""
    text = _Text(of.robot)
    found, _ = of.required()
    return [(str(s.symbol), text(s.expression), s.origin) for s in found]


def base_parameters(robot: Robot) -> list[tuple[str, str, str, str]]:
    """(link, entry of its pseudo-inertia, expression, unit) of the base inertial parameters."""
    text = _Text(robot)
    return [(b.link, b.entry, text(b.expression), b.unit) for b in base.base_parameters(robot)]


def catalogue_rows() -> list[dict[str, Any]]:
    """What people need to know of every effect."""
    rows: list[dict[str, Any]] = []
    for effect in catalogue().values():
        rows.append(
            {
                "effect": effect.identifier,
                "title": effect.title,
                "at": sorted(str(kind) for kind in effect.attaches_to),
                "parameters": {p.name: _parameter(p) for p in effect.parameters},
                "laws": dict(laws(effect)),
                "signature": effect.signature,
                "rivals": list(effect.rivals),
                "builds_on": effect.builds_on,
                "proposable": effect.proposable,
                "source": effect.source,
            }
        )
    return rows


def _parameter(schema: ParameterSchema) -> dict[str, Any]:
    """Units by the motion of the place; ``null``: where the effect vanishes ("inf": without limit; None: nowhere)."""
    return {
        "units": {str(motion): unit for motion, unit in schema.units.items()},
        "null": "inf" if schema.null == math.inf else schema.null,
        "lower": _finite(schema.lower),
        "upper": _finite(schema.upper),
        "meaning": schema.meaning,
        "searched": str(schema.scan) if schema.scan is not Scan.NONE else None,
    }


def _finite(bound: float | None) -> float | None:
    return bound if bound is not None and math.isfinite(bound) else None


def _sum(text: _Text, terms: list[sp.Expr]) -> str:
    shown = [text(term) for term in terms if term != 0]
    if not shown:
        return "0"
    return shown[0] + "".join(f" - {t[1:]}" if t.startswith("-") else f" + {t}" for t in shown[1:])
