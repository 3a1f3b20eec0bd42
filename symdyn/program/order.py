"""A canonical order of SymPy expressions that no hash seed and no history of the process can change."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator

import sympy

Rank = tuple[int, str, bytes]


class StructuralOrder:
    """Sort keys made from structure alone: numbers, then symbols by name, then the rest by kind.

    SymPy stores the arguments of sums and products in an order that need not repeat from one process
    to the next. One instance serves one lowering, and visits every shared subexpression once.
    """

    def __init__(self) -> None:
        self._ranks: dict[int, Rank] = {}
        self._alive: list[sympy.Basic] = []  # ranks are stored by id, so the objects must not go away

    def operands(self, expression: sympy.Basic) -> tuple[sympy.Basic, ...]:
        """The arguments, in canonical order where the operation is commutative."""
        args: tuple[sympy.Basic, ...] = expression.args
        if not _commutes(expression):
            return args
        for argument in args:
            self._visit(argument)
        return tuple(sorted(args, key=lambda argument: self._ranks[id(argument)]))

    def _visit(self, root: sympy.Basic) -> None:
        for expression in _bottom_up(root, self._ranks):
            children = [self._ranks[id(argument)] for argument in expression.args]
            if _commutes(expression):
                children.sort()
            kind = type(expression).__name__
            text = "" if expression.args else str(expression)
            digest = hashlib.blake2b(f"{kind}:{text}".encode(), digest_size=16)
            for child in children:
                digest.update(child[2])
            rank = 0 if expression.is_Number or expression.is_NumberSymbol else 1 if expression.is_Symbol else 2
            self._ranks[id(expression)] = (rank, text or kind, digest.digest())
            self._alive.append(expression)


def _commutes(expression: sympy.Basic) -> bool:
    return isinstance(expression, (sympy.Add, sympy.Mul, sympy.Min, sympy.Max))


def _bottom_up(root: sympy.Basic, done: dict[int, Rank]) -> Iterator[sympy.Basic]:
    """Every expression below ``root`` not yet in ``done``, arguments first, without recursion."""
    stack: list[tuple[sympy.Basic, Iterable[sympy.Basic]]] = [(root, iter(root.args))]
    while stack:
        expression, arguments = stack[-1]
        for argument in arguments:
            if id(argument) not in done:
                stack.append((argument, iter(argument.args)))
                break
        else:
            stack.pop()
            if id(expression) not in done:
                yield expression
