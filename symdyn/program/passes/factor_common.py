"""Common factors taken out of sums: a x + a y - 2 a becomes a (x + y - 2)."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from symdyn.program.cost import cheaper
from symdyn.program.polynomial import Polynomials, Product, Sum, Term
from symdyn.program.polynomial_read import from_program
from symdyn.program.polynomial_write import to_program
from symdyn.program.ssa import Program

_Factor = tuple[int, float]  # (node, 1.0), or (-1, size) of a coefficient
_Monomial = tuple[float, tuple[int, ...]]  # coefficient and factors


def factor_common(program: Program) -> Program:
    """In each sum, take out the factor that most terms share, then the next, as long as a multiplication is saved."""
    view = from_program(program)
    graph = view.graph
    uses = graph.uses(view.outputs)
    changed = False
    for node in range(len(uses)):
        element = graph.elements[node]
        if uses[node] and isinstance(element, Sum) and len(element.terms) > 1:
            monomials = [_monomial(graph, term, uses) for term in element.terms]
            origin = graph.origins[node]
            constant, terms = _factored(graph, element.constant, monomials, origin)
            if terms != element.terms:
                graph.replace(node, Sum(constant, terms))
                changed = True
    return cheaper(program, to_program(view)) if changed else program


def _monomial(graph: Polynomials, term: Term, uses: Sequence[int]) -> _Monomial:
    """The term as factors; a product that others use as well stays one factor."""
    coefficient, node = term
    element = graph.elements[node]
    return (coefficient, element.factors if isinstance(element, Product) and uses[node] == 1 else (node,))


def _may_share(monomials: list[_Monomial]) -> bool:
    """Whether any factor, or size of a coefficient, occurs in two terms: mostly none does."""
    factors = [factor for _, own in monomials for factor in own]
    sizes = [abs(c) for c, _ in monomials if c not in (1.0, -1.0)]
    return len(set(factors)) < len(factors) or len(set(sizes)) < len(sizes)


@dataclass(slots=True)
class _Frame:
    """A sum on its way to being factored, inside the sum that it was taken out of."""

    factor: _Factor | None  # what multiplies it; None for the outermost
    constant: float
    groups: list[tuple[_Factor, list[_Monomial]]]  # still to do: factors, and the terms that have them
    terms: list[Term]


def _factored(
    graph: Polynomials, constant: float, monomials: list[_Monomial], origin: str
) -> tuple[float, tuple[Term, ...]]:
    """Constant and terms of a sum after its common factors were taken out, innermost sums first."""
    stack = [_frame(graph, None, constant, monomials, origin)]
    while True:
        frame = stack[-1]
        if frame.groups:
            factor, members = frame.groups.pop()
            inner = [_quotient(member, factor) for member in members]
            alone = math.fsum(c for c, factors in inner if not factors)
            stack.append(_frame(graph, factor, alone, [m for m in inner if m[1]], origin))
            continue
        stack.pop()
        if frame.factor is None:
            break
        inside = graph.sum(frame.constant, frame.terms, origin)
        node, size = frame.factor
        whole = graph.product(1.0, (node, inside), origin) if node >= 0 else graph.product(size, (inside,), origin)
        stack[-1].terms.append(_as_term(graph, whole))
    collected: dict[int, float] = {}
    for coefficient, node in frame.terms:
        collected[node] = collected.get(node, 0.0) + coefficient
    return frame.constant, tuple((c, node) for node, c in sorted(collected.items()) if c != 0.0)


def _frame(
    graph: Polynomials, factor: _Factor | None, constant: float, monomials: list[_Monomial], origin: str
) -> _Frame:
    groups, rest = _grouped(monomials)
    terms = [_as_term(graph, graph.product(c, factors, origin)) for c, factors in rest]
    return _Frame(factor, constant, groups, terms)


def _as_term(graph: Polynomials, node: int) -> Term:
    return graph.single_term(node) or (1.0, node)


def _grouped(monomials: list[_Monomial]) -> tuple[list[tuple[_Factor, list[_Monomial]]], list[_Monomial]]:
    """Terms grouped by the factor that saves most multiplications, the earliest of equals; and the rest."""
    if not _may_share(monomials):
        return [], monomials
    members: dict[_Factor, dict[int, bool]] = {}  # factor -> term -> whether dividing saves a multiplication
    for place, monomial in enumerate(monomials):
        for factor, saves in _divisors(monomial):
            members.setdefault(factor, {})[place] = saves
    heap = [(-sum(places.values()), factor) for factor, places in members.items() if sum(places.values()) > 1]
    heapq.heapify(heap)
    groups: list[tuple[_Factor, list[_Monomial]]] = []
    taken: set[int] = set()
    while heap:
        negative_count, factor = heapq.heappop(heap)
        saved = sum(members[factor].values())
        if saved != -negative_count:  # out of date: some of its terms were taken
            if saved > 1:
                heapq.heappush(heap, (-saved, factor))
            continue
        places = list(members[factor])
        groups.append((factor, [monomials[place] for place in places]))
        taken.update(places)
        for place in places:
            for other, _ in _divisors(monomials[place]):
                members[other].pop(place, None)
    return groups, [monomial for place, monomial in enumerate(monomials) if place not in taken]


def _divisors(monomial: _Monomial) -> Iterator[tuple[_Factor, bool]]:
    """Every factor of a term, and whether dividing by it saves a multiplication."""
    coefficient, factors = monomial
    plain = abs(coefficient) == 1.0
    for node in dict.fromkeys(factors):
        yield (node, 1.0), not plain or len(factors) > 1
    if not plain:
        yield (-1, abs(coefficient)), True


def _quotient(monomial: _Monomial, factor: _Factor) -> _Monomial:
    coefficient, factors = monomial
    node, _ = factor
    if node < 0:
        return (1.0 if coefficient > 0.0 else -1.0, factors)
    place = factors.index(node)
    return coefficient, factors[:place] + factors[place + 1 :]
