"""From a program to its polynomial view: chains become sums and products, signs move outwards.

A chain is merged where the inner line has no other user, so that nothing is computed twice.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from symdyn.program.polynomial import Call, Input, PolynomialProgram, Polynomials, Product, Sum, Term
from symdyn.program.ssa import Node, Op, Program

_EVEN = frozenset({Op.COS, Op.ABS})
_ODD = frozenset({Op.SIN, Op.TAN, Op.TANH, Op.SIGN})


def from_program(program: Program) -> PolynomialProgram:
    """Collect the chains of a program; signs move through products and odd functions to a sum."""
    work = _Collector(program)
    for index in range(len(program.nodes)):
        work.collect(index)
    outputs = [work.node[output] for output in program.outputs]
    return PolynomialProgram(program.name, program.arguments, work.graph, outputs, program.shape)


_INNER = -1  # in place of a node: the line is inside a chain, and is read with the chain's last line


class _Collector:
    def __init__(self, program: Program) -> None:
        self.graph = Polynomials()
        self.node: list[int] = []
        self._lines = program.nodes
        self._uses, self._inner = _chains(program)
        self._users: dict[int, int] = {}  # by node of the graph: uses by lines that became it

    def collect(self, index: int) -> None:
        if self._inner[index]:
            self.node.append(_INNER)
            return
        line = self._lines[index]
        node = self._node(index, line)
        self.node.append(node)
        self._users[node] = self._users.get(node, 0) + self._uses[index]
        if line.op is not Op.INPUT and self.graph.labels[node] is None:
            self.graph.labels[node] = line.name

    def _node(self, index: int, line: Node) -> int:
        origin = line.origin
        match line.op:
            case Op.CONST:
                assert line.value is not None
                return self.graph.sum(line.value, (), origin)
            case Op.INPUT:
                assert line.name is not None
                return self.graph.add(Input(line.name))
            case Op.ADD | Op.SUB | Op.NEG:
                return self._sum(self._terms(index), origin)
            case Op.MUL:
                return self._product(self._factors(index), origin)
        args = [self.node[argument] for argument in line.args]
        return self._divide(args, origin) if line.op is Op.DIV else self._call(line.op, args, origin)

    def _terms(self, last: int) -> list[Term]:
        """Nodes with their signs that the chain of additions ending at a line adds up."""
        terms: list[Term] = []
        stack = [(1.0, last)]
        while stack:
            sign, index = stack.pop()
            if index != last and not self._inner[index]:
                terms.append((sign, self.node[index]))
                continue
            line = self._lines[index]
            right = sign if line.op is Op.ADD else -sign
            stack.append((right, line.args[-1]))
            if line.op is not Op.NEG:
                stack.append((sign, line.args[0]))
        return terms

    def _factors(self, last: int) -> list[int]:
        """Nodes that the chain of multiplications ending at a line multiplies."""
        factors: list[int] = []
        stack = [last]
        while stack:
            index = stack.pop()
            if index == last or self._inner[index]:
                stack.extend(reversed(self._lines[index].args))
            else:
                factors.append(self.node[index])
        return factors

    def _alone(self, node: int) -> bool:
        """Whether the node has one user, the chain that is being collected."""
        return self._users.get(node, 1) <= 1

    def _sum(self, terms: list[Term], origin: str) -> int:
        times = Counter(node for _, node in terms)
        constant, flat = 0.0, list[Term]()
        for coefficient, node in terms:
            element = self.graph.elements[node]
            alone = self._alone(node) and times[node] == 1
            if isinstance(element, Sum) and (alone or not element.terms or self._is_sign(node)):
                constant += coefficient * element.constant
                flat.extend((coefficient * c, inner) for c, inner in element.terms)
            else:
                flat.append((coefficient, node))
        # What was the negative of a sum that has no other user: open that sum as well.
        if len(flat) == 1 and constant == 0.0 and flat[0][1] != terms[0][1] and abs(flat[0][0]) == 1.0:
            sign, node = flat[0]
            element = self.graph.elements[node]
            if isinstance(element, Sum) and self._alone(node):
                constant, flat = sign * element.constant, [(sign * c, inner) for c, inner in element.terms]
        return self._oriented(constant, flat, origin)

    def _oriented(self, constant: float, terms: list[Term], origin: str) -> int:
        """A sum whose first term is positive, behind a sign if need be: a - b and b - a are one sum."""
        node = self.graph.sum(constant, terms, origin)
        element = self.graph.elements[node]
        if not isinstance(element, Sum) or len(element.terms) + (element.constant != 0.0) < 2:
            return node
        if not element.terms or element.terms[0][0] > 0.0:
            return node
        flipped = self.graph.sum(-element.constant, [(-c, inner) for c, inner in element.terms], origin)
        return self.graph.sum(0.0, [(-1.0, flipped)], origin)

    def _is_sign(self, node: int) -> bool:
        term = self.graph.single_term(node)
        return term is not None and term[0] == -1.0

    def _unsigned(self, node: int) -> Term:
        """The node as a sign times a node."""
        term = self.graph.single_term(node)
        return term if term is not None and term[0] == -1.0 else (1.0, node)

    def _product(self, nodes: Sequence[int], origin: str) -> int:
        times = Counter(nodes)
        coefficient, factors = 1.0, list[int]()
        for node in nodes:
            scale, factor, alone = 1.0, node, self._alone(node) and times[node] == 1
            term = self.graph.single_term(node)
            if term is not None and (alone or term[0] == -1.0):
                scale, factor = term
                alone = alone and self._alone(factor)
            element = self.graph.elements[factor]
            if isinstance(element, Sum) and not element.terms:
                scale *= element.constant
            elif isinstance(element, Product) and alone:
                factors.extend(element.factors)
            else:
                factors.append(factor)
            coefficient *= scale
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


_ADDITIVE = frozenset({Op.ADD, Op.SUB, Op.NEG})


def _chains(program: Program) -> tuple[list[int], list[bool]]:
    """Of each line: how many lines and outputs use it; whether it only continues the chain of its one user."""
    uses = [0] * len(program.nodes)
    inner = [False] * len(program.nodes)
    for line in program.nodes:
        for argument in dict.fromkeys(line.args):
            uses[argument] += 1
            op = program.nodes[argument].op
            same_chain = (line.op in _ADDITIVE and op in _ADDITIVE) or line.op is op is Op.MUL
            inner[argument] = same_chain and line.args.count(argument) == 1
    for output in program.outputs:
        uses[output] += 1
        inner[output] = False
    return uses, [is_inner and times == 1 for is_inner, times in zip(inner, uses, strict=True)]
