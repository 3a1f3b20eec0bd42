"""Steps of a derivation: each intermediate, its expression and the law that it came from."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp


@dataclass(frozen=True, slots=True)
class Step:
    """``symbol = expression``; ``origin`` says which link and which law ("link 2: angular velocity")."""

    symbol: sp.Symbol
    expression: sp.Expr
    origin: str


class Steps:
    """Collects the steps of one derivation in order; naming what is not already a number or a symbol."""

    def __init__(self) -> None:
        self._steps: list[Step] = []
        self._taken: set[str] = set()

    def name(self, name: str, expression: sp.Expr, origin: str) -> sp.Expr:
        """The symbol ``name`` for an expression; numbers, symbols and their negatives stay themselves.

        A name that is taken (one effect twice at one place) is numbered: ``name_2``, ``name_3``, ...
        """
        if expression.is_Atom or _is_negative_atom(expression):
            return expression
        free, count = name, 1
        while free in self._taken:
            count += 1
            free = f"{name}_{count}"
        self._taken.add(free)
        symbol = sp.Symbol(free, real=True)
        self._steps.append(Step(symbol, expression, origin))
        return symbol

    def vector(self, name: str, vector: sp.Matrix, origin: str) -> sp.Matrix:
        """(3, 1): the vector with its entries named ``name_x``, ``name_y``, ``name_z``."""
        entries = zip("xyz", vector, strict=True)
        return sp.Matrix([self.name(f"{name}_{axis}", entry, origin) for axis, entry in entries])

    def matrix(self, name: str, matrix: sp.Matrix, origin: str) -> sp.Matrix:
        """The matrix with its entries named ``name_11``, ``name_12``, ...; products are then formed once."""
        return sp.Matrix(*matrix.shape, lambda r, k: self.name(f"{name}_{r + 1}{k + 1}", matrix[r, k], origin))

    def freeze(self) -> tuple[Step, ...]:
        return tuple(self._steps)


def _is_negative_atom(expression: sp.Expr) -> bool:
    args = expression.args
    return expression.is_Mul and len(args) == 2 and args[0] is sp.S.NegativeOne and args[1].is_Atom
