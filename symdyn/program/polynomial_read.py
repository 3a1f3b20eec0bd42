"""From a program to its polynomial view: chains become sums and products, signs move outwards.

A chain is merged where the inner line has no other user, so that nothing is computed twice.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Sequence
from functools import lru_cache

from symdyn.program.polynomial import Call, Input, PolynomialProgram, Polynomials, Product, Sum, Term, collect
from symdyn.program.ssa import Node, Op, Program

_ADD, _MUL = Op.ADD, Op.MUL  # looked up once: on an Enum class that costs as much as the work
_ADDITIVE = frozenset({Op.ADD, Op.SUB, Op.NEG})
_EVEN = frozenset({Op.COS, Op.ABS})
_ODD = frozenset({Op.SIN, Op.TAN, Op.TANH, Op.SIGN})


def from_program(program: Program) -> PolynomialProgram:
    """Collect the chains of a program; signs move through products and odd functions to a sum."""
    graph, outputs = _read(program)
    return PolynomialProgram(program.name, program.arguments, graph.copy(), list(outputs), program.shape)


@lru_cache(maxsize=1)  # a pass that changes nothing leaves the next one the same program to read
def _read(program: Program) -> tuple[Polynomials, tuple[int, ...]]:
    work = _Collector(program)
    work.collect()
    return work.graph, tuple([work.node[output] for output in program.outputs])


_INNER = -1  # in place of a node: the line is inside a chain, and is read with the chain's last line


class _Collector:
    def __init__(self, program: Program) -> None:
        self.graph = Polynomials()
        self.node: list[int] = []
        self._lines = program.nodes
        self._uses, self._inner = _chains(program)
        self._users: dict[int, int] = {}  # by node of the graph: uses by lines that became it

    def collect(self) -> None:
        users, labels = self._users, self.graph.labels
        for index, (line, inner, uses) in enumerate(zip(self._lines, self._inner, self._uses, strict=True)):
            if inner:
                self.node.append(_INNER)
                continue
            node = self._node(index, line)
            self.node.append(node)
            users[node] = users.get(node, 0) + uses
            if line.args and labels[node] is None:
                labels[node] = line.name

    def _node(self, index: int, line: Node) -> int:
        op, operands, value, name, origin = line
        if op is _MUL:
            return self._product(self._factors(index), origin)
        if op in _ADDITIVE:
            return self._sum(self._terms(index), origin)
        if value is not None:
            return self.graph.sum(value, (), origin)
        if not operands:
            assert name is not None
            return self.graph.add(Input(name))
        args = [self.node[argument] for argument in operands]
        return self._divide(args, origin) if op is Op.DIV else self._call(op, args, origin)

    def _terms(self, last: int) -> list[Term]:
        """Nodes with their signs that the chain of additions ending at a line adds up."""
        nodes, lines = self.node, self._lines
        terms: list[Term] = []
        stack = [(1.0, last)]
        while stack:
            sign, index = stack.pop()
            if index != last and nodes[index] != _INNER:
                terms.append((sign, nodes[index]))
                continue
            op, args, *_ = lines[index]
            stack.append((sign if op is _ADD else -sign, args[-1]))
            if len(args) == 2:
                stack.append((sign, args[0]))
        return terms

    def _factors(self, last: int) -> list[int]:
        """Nodes that the chain of multiplications ending at a line multiplies."""
        nodes, lines = self.node, self._lines
        factors: list[int] = []
        stack = list(lines[last].args[::-1])
        while stack:
            index = stack.pop()
            if nodes[index] == _INNER:
                stack.extend(lines[index].args[::-1])
            else:
                factors.append(nodes[index])
        return factors

    def _alone(self, node: int) -> bool:
        """Whether the node has one user, the chain that is being collected."""
        return self._users.get(node, 1) <= 1

    def _sum(self, terms: list[Term], origin: str) -> int:
        elements = self.graph.elements
        repeated = _repeated([node for _, node in terms])
        constant, flat = 0.0, list[Term]()
        for term in terms:
            coefficient, node = term
            element = elements[node]
            if isinstance(element, Sum) and (
                not element.terms or self._is_sign(node) or (self._alone(node) and node not in repeated)
            ):
                constant += coefficient * element.constant
                flat += [(coefficient * c, inner) for c, inner in element.terms]
            else:
                flat.append(term)
        # What was the negative of a sum that has no other user: open that sum as well.
        if len(flat) == 1 and constant == 0.0 and flat[0][1] != terms[0][1] and abs(flat[0][0]) == 1.0:
            sign, node = flat[0]
            element = elements[node]
            if isinstance(element, Sum) and self._alone(node):
                constant, flat = sign * element.constant, [(sign * c, inner) for c, inner in element.terms]
        return self._oriented(constant, flat, origin)

    def _oriented(self, constant: float, terms: list[Term], origin: str) -> int:
        """A sum whose first term is positive, behind a sign if need be: a - b and b - a are one sum."""
        kept = collect(terms)
        if not kept or kept[0][0] > 0.0 or (len(kept) == 1 and constant == 0.0):
            return self.graph.sum(constant, kept, origin)
        flipped = self.graph.sum(-constant, [(-c, inner) for c, inner in kept], origin)
        return self.graph.add(Sum(0.0, ((-1.0, flipped),)), origin)

    def _is_sign(self, node: int) -> bool:
        term = self.graph.single_term(node)
        return term is not None and term[0] == -1.0

    def _unsigned(self, node: int) -> Term:
        """The node as a sign times a node."""
        term = self.graph.single_term(node)
        return term if term is not None and term[0] == -1.0 else (1.0, node)

    def _product(self, nodes: Sequence[int], origin: str) -> int:
        elements = self.graph.elements
        repeated = _repeated(nodes)
        coefficient, factors = 1.0, list[int]()
        for node in nodes:
            factor, element = node, elements[node]
            if isinstance(element, Sum):
                term = self.graph.single_term(node)
                if term is not None and (term[0] == -1.0 or (self._alone(node) and node not in repeated)):
                    coefficient *= term[0]
                    factor = term[1]
                    element = elements[factor]
            if isinstance(element, Sum) and not element.terms:
                coefficient *= element.constant
            elif isinstance(element, Product) and self._alone(node) and node not in repeated and self._alone(factor):
                factors.extend(element.factors)
            else:
                factors.append(factor)
        if not math.isfinite(coefficient):
            return self.graph.add(Product(tuple(sorted(nodes))), origin)
        return self.graph.product(coefficient, factors, origin)

    def _divide(self, args: Sequence[int], origin: str) -> int:
        (above, numerator), (below, denominator) = self._unsigned(args[0]), self._unsigned(args[1])
        quotient = self.graph.add(Call(Op.DIV, (numerator, denominator)), origin)
        return self.graph.sum(0.0, [(above * below, quotient)], origin)

    def _call(self, op: Op, args: Sequence[int], origin: str) -> int:
        if op in _EVEN or op in _ODD:
            sign, argument = self._unsigned(args[0])
            value = self.graph.add(Call(op, (argument,)), origin)
            return self.graph.sum(0.0, [(sign if op in _ODD else 1.0, value)], origin)
        return self.graph.add(Call(op, tuple(args)), origin)


def _repeated(nodes: Sequence[int]) -> Collection[int]:
    """The nodes that occur more than once."""
    if len(set(nodes)) == len(nodes):
        return ()
    return {node for node, times in Counter(nodes).items() if times > 1}


def _chains(program: Program) -> tuple[list[int], list[bool]]:
    """Of each line: how many lines and outputs use it; whether it only continues the chain of its one user."""
    nodes = program.nodes
    chain = [op if op is _MUL else _ADD if op in _ADDITIVE else None for op, *_ in nodes]
    uses = [0] * len(nodes)
    inner = [False] * len(nodes)
    for (_, args, *_), own in zip(nodes, chain, strict=True):
        if len(args) == 2 and args[0] == args[1]:
            uses[args[0]] += 1
            inner[args[0]] = False
            continue
        for argument in args:
            uses[argument] += 1
            inner[argument] = own is not None and chain[argument] is own
    for output in program.outputs:
        uses[output] += 1
        inner[output] = False
    return uses, [is_inner and times == 1 for is_inner, times in zip(inner, uses, strict=True)]
