"""Common parts of sums and products shared: a b c and a b d form a b once.

Equal lines are one line already, by hash-consing; this finds what the order of a chain hid. Greedy:
the pair that occurs in most sums (or products) becomes an element of its own, again and again.
"""

from __future__ import annotations

import bisect
import heapq
from collections.abc import Callable, Iterable

from symdyn.program.cost import cheaper
from symdyn.program.polynomial import Element, Polynomials, Product, Sum, Term
from symdyn.program.polynomial_read import from_program
from symdyn.program.polynomial_write import to_program
from symdyn.program.ssa import Program

_WINDOW = 32  # operands of one sum or product that are paired: the time stays linear in its width

_Pair = tuple[Term, Term]


def share_subexpressions(program: Program) -> Program:
    """Share pairs of factors, then pairs of terms up to a common sign."""
    view = from_program(program)
    graph = view.graph
    live = [node for node, uses in enumerate(graph.uses(view.outputs)) if uses]
    products: dict[int, list[Term]] = {}
    sums: dict[int, list[Term]] = {}
    for node in live:
        element = graph.elements[node]
        if isinstance(element, Product):
            products[node] = [(1.0, factor) for factor in element.factors]
        elif isinstance(element, Sum) and len(element.terms) > 1:
            sums[node] = sorted(element.terms, key=_by_node)
    _share(graph, products, lambda pair: Product(tuple(node for _, node in pair)))
    for node, row in products.items():
        graph.replace(node, Product(tuple(factor for _, factor in row)))
    _share(graph, sums, lambda pair: Sum(0.0, pair))
    for node, row in sums.items():
        element = graph.elements[node]
        assert isinstance(element, Sum)
        graph.replace(node, Sum(element.constant, tuple(row)))
    return cheaper(program, to_program(view))


def _share(graph: Polynomials, rows: dict[int, list[Term]], element: Callable[[_Pair], Element]) -> None:
    """Replace pairs in the rows, which are in order of nodes, by new rows that hold the pair."""
    where: dict[_Pair, dict[int, None]] = {}
    for node, row in rows.items():
        for pair in _pairs(row):
            where.setdefault(pair, {})[node] = None
    heap = [(-len(nodes), pair) for pair, nodes in where.items() if len(nodes) > 1]
    heapq.heapify(heap)
    while heap:
        negative_count, pair = heapq.heappop(heap)
        nodes = where.get(pair, {})
        if len(nodes) < 2:
            continue
        if len(nodes) != -negative_count:  # out of date: the rows have changed since
            heapq.heappush(heap, (-len(nodes), pair))
            continue
        shared = graph.add(element(pair), graph.origins[next(iter(nodes))])
        for node in list(nodes):
            if node == shared:
                continue
            for old in _pairs(rows[node]):
                where[old].pop(node, None)
            rows[node] = _replaced(rows[node], pair, shared)
            for new in _pairs(rows[node]):
                holders = where.setdefault(new, {})
                holders[node] = None
                if len(holders) > 1:
                    heapq.heappush(heap, (-len(holders), new))
        if shared not in rows:
            rows[shared] = list(pair)
        where[pair] = {}


def _pairs(row: list[Term]) -> Iterable[_Pair]:
    """The distinct pairs of a row, each with its first coefficient positive."""
    head = row[:_WINDOW]
    turned = [(-c, node) for c, node in head]
    pairs: list[_Pair] = []
    for place, first in enumerate(head):
        if first[0] > 0.0:
            pairs += [(first, other) for other in head[place + 1 :]]
        else:
            pairs += [(turned[place], other) for other in turned[place + 1 :]]
    return dict.fromkeys(pairs)


def _replaced(row: list[Term], pair: _Pair, shared: int) -> list[Term]:
    """The row with one occurrence of the pair, or of its negative, replaced by the shared element."""
    rest = list(row)
    sign = 1.0 if pair[0] in rest and pair[1] in rest else -1.0
    for coefficient, node in pair:
        rest.remove((sign * coefficient, node))
    bisect.insort(rest, (sign, shared), key=_by_node)
    return rest


def _by_node(term: Term) -> int:
    return term[1]
