"""A second view of a program, for passes that reorder: sums of many terms, products of many factors.

In a chain of binary additions the order is an accident; here a ``Sum`` is a constant and terms with
coefficients, a ``Product`` a multiset of factors, and a change of sign is a coefficient of -1.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from symdyn.program.ssa import Argument, Op

Term = tuple[float, int]  # coefficient, node


class Sum(NamedTuple):
    """``constant + sum(coefficient * node)``; each node once, in ascending order."""

    constant: float
    terms: tuple[Term, ...]


class Product(NamedTuple):
    """The product of the factors, in ascending order; a repeated factor is a power."""

    factors: tuple[int, ...]


class Call(NamedTuple):
    """Any other operation."""

    op: Op
    args: tuple[int, ...]


class Input(NamedTuple):
    name: str


Element = Sum | Product | Call | Input  # no two kinds are ever equal as tuples: their entries differ in type


def operands(element: Element) -> tuple[int, ...]:
    """The nodes that an element is made from."""
    if isinstance(element, Product):
        return element.factors
    if isinstance(element, Sum):
        return tuple([node for _, node in element.terms])
    return element.args if isinstance(element, Call) else ()


def collect(terms: Iterable[Term]) -> tuple[Term, ...]:
    """Like terms added up, in ascending order of nodes; those with coefficient 0 are gone."""
    collected: dict[int, float] = {}
    for coefficient, node in terms:
        collected[node] = collected.get(node, 0.0) + coefficient
    return tuple([(c, node) for node, c in sorted(collected.items()) if c])


class Polynomials:
    """Elements under construction, hash-consed; elements may be replaced and need no order."""

    def __init__(self) -> None:
        self.elements: list[Element] = []
        self.labels: list[str | None] = []
        self.origins: list[str] = []
        self._known: dict[Element, int] = {}

    def copy(self) -> Polynomials:
        """The same elements; what is done to one of the two leaves the other as it is."""
        twin = Polynomials()
        twin.elements, twin.labels = self.elements.copy(), self.labels.copy()
        twin.origins, twin._known = self.origins.copy(), self._known.copy()
        return twin

    def add(self, element: Element, origin: str = "") -> int:
        """The number of the element, made if it is new."""
        node = self._known.get(element)
        if node is None:
            node = self._known[element] = len(self.elements)
            self.elements.append(element)
            self.labels.append(None)
            self.origins.append(origin)
        return node

    def sum(self, constant: float, terms: Sequence[Term], origin: str = "") -> int:
        """A sum with like terms collected; one with a single plain term is that term."""
        kept = collect(terms)
        if constant == 0.0 and len(kept) == 1 and kept[0][0] == 1.0:
            return kept[0][1]
        return self.add(Sum(constant + 0.0, kept), origin)

    def product(self, coefficient: float, factors: Sequence[int], origin: str = "") -> int:
        """A coefficient times factors: one factor is itself, a coefficient other than 1 a sum of one term."""
        if coefficient == 0.0 or not factors:
            return self.sum(coefficient, (), origin)
        node = factors[0] if len(factors) == 1 else self.add(Product(tuple(sorted(factors))), origin)
        return node if coefficient == 1.0 else self.add(Sum(0.0, ((coefficient, node),)), origin)

    def replace(self, node: int, element: Element) -> None:
        """Give a node another form of the same value; its users stay."""
        if self._known.get(self.elements[node]) == node:
            del self._known[self.elements[node]]
        self.elements[node] = element

    def single_term(self, node: int) -> Term | None:
        """(c, x) where the node is the sum of that one term and no constant."""
        element = self.elements[node]
        if isinstance(element, Sum) and len(element.terms) == 1 and element.constant == 0.0:
            return element.terms[0]
        return None

    def uses(self, outputs: Sequence[int]) -> list[int]:
        """How often each node is used by nodes that the outputs need, and by the outputs; 0 if dead."""
        elements = self.elements
        uses = [0] * len(elements)
        for output in outputs:
            uses[output] += 1
        stack = list(dict.fromkeys(outputs))
        while stack:
            for operand in set(operands(elements[stack.pop()])):
                if not uses[operand]:
                    stack.append(operand)
                uses[operand] += 1
        return uses


@dataclass(slots=True)
class PolynomialProgram:
    """The polynomial view of one program."""

    name: str
    arguments: tuple[Argument, ...]
    graph: Polynomials
    outputs: list[int]
    shape: tuple[int, ...]
