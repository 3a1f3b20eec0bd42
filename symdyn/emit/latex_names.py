"""How symbols are written in LaTeX: coordinates with dots, parameters by their own names."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp

from symdyn.base import symbols
from symdyn.derive.equations import EquationsOfMotion


def latex_names(equations: EquationsOfMotion) -> dict[sp.Symbol, str]:
    """LaTeX of every symbol of the equations; users' names were escaped when they were read."""
    names: dict[sp.Symbol, str] = {}
    for i, axis in enumerate(equations.axes, start=1):
        names[symbols.arm_effort(i)] = rf"\tau^{{\mathrm{{arm}}}}_{{{i}}}(q, \dot{{q}}, \ddot{{q}})"
        names[symbols.load(i)] = rf"\tau^{{\mathrm{{load}}}}_{{{i}}}"
        names[axis.q], names[axis.qd], names[axis.qdd] = f"q_{{{i}}}", rf"\dot{{q}}_{{{i}}}", rf"\ddot{{q}}_{{{i}}}"
    for symbol, parameter in zip(equations.parameters, equations.robot.parameters, strict=True):
        names[symbol] = parameter.latex
    for state in equations.states:
        index = str(state.symbol).rpartition("_")[2]
        names[state.symbol] = state.latex if len(equations.states) == 1 else f"{state.latex}_{{{index}}}"
    for item in equations.inputs:
        index = str(item.symbol).rpartition("_")[2]
        names[item.symbol] = rf"\tau_{{{index}}}" if item.name.endswith(".effort") else f"u_{{{index}}}"
    return names


class Printer:
    """LaTeX of expressions in the names of one set of equations."""

    def __init__(self, equations: EquationsOfMotion, more: Mapping[sp.Symbol, str] | None = None) -> None:
        self._names = latex_names(equations) | dict(more or {})

    def __call__(self, expression: sp.Expr) -> str:
        return str(
            sp.latex(
                expression,
                symbol_names=self._names,
                mul_symbol=r" \, ",
                fold_short_frac=False,
                ln_notation=True,
                root_notation=True,
            )
        )
