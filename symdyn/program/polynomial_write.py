"""From the polynomial view back to a program: the cheapest chains of binary operations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from symdyn.program.builder import Builder
from symdyn.program.folding import fold
from symdyn.program.polynomial import Call, Element, Input, PolynomialProgram, Product, Sum, operands
from symdyn.program.ssa import Op, Program


def to_program(view: PolynomialProgram) -> Program:
    """Write every live element as lines, in the order of the elements where their operands allow."""
    work = _Writer(view)
    for node, uses in enumerate(work.uses):
        if uses:
            work.write(node)
    outputs = [work.line[output] for output in view.outputs]
    return work.builder.program(view.name, view.arguments, outputs, view.shape)


_ADD, _SUB, _MUL = Op.ADD, Op.SUB, Op.MUL


class _Writer:
    def __init__(self, view: PolynomialProgram) -> None:
        self.builder = Builder()
        self.line: dict[int, int] = {}
        self._graph = view.graph
        self.uses = view.graph.uses(view.outputs)
        self._origin = ""

    def write(self, root: int) -> None:
        line, graph = self.line, self._graph
        stack = [root]
        while stack:
            node = stack[-1]
            if node in line:
                stack.pop()
                continue
            element = self._negated(node) or graph.elements[node]
            waiting = [operand for operand in operands(element) if operand not in line]
            if waiting:
                waiting.reverse()
                stack += waiting
                continue
            self._origin = graph.origins[node]
            line[node] = self._lines(element)
            label = graph.labels[node]
            if label is not None and not isinstance(element, Input):
                self.builder.label(line[node], label)

    def _negated(self, node: int) -> Element | None:
        """Where the node is -x and x has no other user: a form of -x that needs no change of sign."""
        term = self._graph.single_term(node)
        if term is None or term[0] != -1.0:
            return None
        inner = term[1]
        while (alias := self._graph.single_term(inner)) is not None and alias[0] == 1.0 and self.uses[inner] == 1:
            inner = alias[1]
        if self.uses[inner] > 1:
            return None
        element = self._graph.elements[inner]
        if isinstance(element, Sum):
            return _flipped(element)
        if isinstance(element, Product):
            for place, factor in enumerate(element.factors):
                if element.factors.count(factor) == 1 and (turned := self._turned(factor)) is not None:
                    return Product((*element.factors[:place], turned, *element.factors[place + 1 :]))
        if isinstance(element, Call) and element.op is Op.DIV:
            above, below = element.args
            if (turned := self._turned(above)) is not None:
                return Call(Op.DIV, (turned, below))
            if (turned := self._turned(below)) is not None:
                return Call(Op.DIV, (above, turned))
        return None

    def _turned(self, node: int) -> int | None:
        """The node of the negative, if the node is a sum with no other user whose sign turns freely."""
        element = self._graph.elements[node]
        if self.uses[node] > 1 or not isinstance(element, Sum) or _all_negative(_flipped(element)):
            return None
        turned = self._graph.add(_flipped(element), self._graph.origins[node])
        self.uses.extend([1] * (len(self._graph.elements) - len(self.uses)))
        return turned

    def _lines(self, element: Element) -> int:
        line = self.line
        if isinstance(element, Product):
            lines = [line[factor] for factor in element.factors]
            return self._chain(lines) if len(set(lines)) == len(lines) else self._powers(Counter(lines))
        if isinstance(element, Sum):
            return self._sum(element)
        if isinstance(element, Call):
            return fold(self.builder, element.op, tuple([line[argument] for argument in element.args]), self._origin)
        return self.builder.input(element.name)

    def _sum(self, element: Sum) -> int:
        """A chain that starts with a positive term, so that the other signs are subtractions."""
        terms = list(element.terms)
        constant = element.constant
        if not terms:
            return self.builder.constant(constant)
        start = next((place for place, (c, _) in enumerate(terms) if c > 0.0), None)
        if start is None and constant != 0.0:
            total, constant = self.builder.constant(constant), 0.0
        elif start is None and _all_negative(element):
            positive = Sum(0.0, tuple((-c, node) for c, node in terms))
            return self._make(Op.NEG, self._sum(positive))
        else:
            if start is None:
                start = next(place for place, (c, _) in enumerate(terms) if c != -1.0)
            coefficient, node = terms.pop(start)
            total = self._scaled(coefficient, node)
        for coefficient, node in terms:
            op = _ADD if coefficient > 0.0 else _SUB
            total = fold(self.builder, op, (total, self._scaled(abs(coefficient), node)), self._origin)
        if constant != 0.0:
            total = self._make(Op.ADD if constant > 0.0 else Op.SUB, total, self.builder.constant(abs(constant)))
        return total

    def _scaled(self, coefficient: float, node: int) -> int:
        line = self.line[node]
        return line if coefficient == 1.0 else self._make(Op.MUL, self.builder.constant(coefficient), line)

    def _powers(self, exponents: Counter[int]) -> int:
        """A product of powers by repeated squaring of what several factors share: x^3 y^2 = x (x y)^2."""
        odd = [factor for factor, exponent in exponents.items() if exponent % 2]
        halves = Counter({factor: exponent // 2 for factor, exponent in exponents.items() if exponent > 1})
        result = self._chain(odd) if odd else None
        if halves:
            root = self._powers(halves)  # as deep as the number of bits of the largest exponent
            square = self._make(Op.MUL, root, root)
            result = square if result is None else self._make(Op.MUL, result, square)
        assert result is not None
        return result

    def _chain(self, factors: Sequence[int]) -> int:
        result = factors[0]
        for factor in factors[1:]:
            result = fold(self.builder, _MUL, (result, factor), self._origin)
        return result

    def _make(self, op: Op, *args: int) -> int:
        return fold(self.builder, op, args, self._origin)


def _flipped(element: Sum) -> Sum:
    return Sum(0.0 - element.constant, tuple((-c, node) for c, node in element.terms))


def _all_negative(element: Sum) -> bool:
    """Whether the sum can only be written with a change of sign."""
    return element.constant == 0.0 and all(c == -1.0 for c, _ in element.terms)
