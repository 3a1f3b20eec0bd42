"""Prints a program as the lines of a function body, in any language whose expressions read like Python's or C's."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from symdyn.program.angles import Turned, angles_first
from symdyn.program.ssa import NULLARY, Node, Op, Program

ADDITIVE, MULTIPLICATIVE, UNARY, ATOM = range(1, 5)  # binding strength, weakest first
LINE_WIDTH = 100
PARAMETERS = "p"  # the vector that all states of a batch share

INFIX: Mapping[Op, tuple[str, int]] = {
    Op.ADD: (" + ", ADDITIVE),
    Op.SUB: (" - ", ADDITIVE),
    Op.MUL: (" * ", MULTIPLICATIVE),
    Op.DIV: (" / ", MULTIPLICATIVE),
}


@dataclass(frozen=True, slots=True)
class Syntax:
    """All that the printer must know of a language. Entries of vectors count from 0 here.

    Operators group to the left, and a minus sign binds tighter than ``*``.
    """

    calls: Mapping[Op, str]  # the function for every operation that INFIX and the minus sign do not write
    reserved: frozenset[str]  # what a variable must not be called
    define: Callable[[str, str], str]  # (name, value): a new local variable
    store: Callable[[str, str], str]  # (place, value): write to an output
    comment: Callable[[str], str]  # of one line of printable text
    entry: Callable[[str, int], str] = "{}[{}]".format  # (vector, index)
    number: Callable[[float], str] = repr  # to the last bit; given a float, as repr prints it
    turns: Callable[[Sequence[str], Sequence[str]], str] | None = None  # (names, angles): sine, cosine, sine, ...


class _Text:
    """An expression being built: its text and how tightly it binds."""

    __slots__ = ("strength", "text")

    def __init__(self, text: str, strength: int = ATOM) -> None:
        self.text, self.strength = text, strength

    def inside(self, strength: int) -> str:
        return self.text if self.strength >= strength else f"({self.text})"


class Names:
    """Hands out variable names, each once, and none that is reserved."""

    def __init__(self, reserved: Iterable[str]) -> None:
        self._taken = set(reserved)

    def unique(self, wanted: str) -> str:
        name, count = wanted, 1
        while name in self._taken:
            count += 1
            name = f"{wanted}_{count}"
        self._taken.add(name)
        return name


def argument_names(program: Program, syntax: Syntax) -> tuple[str, ...]:
    """What the function calls its vectors: their own names, unless these are reserved."""
    names = Names(syntax.reserved)
    return tuple(names.unique(argument.name) for argument in program.arguments)


def used_symbols(program: Program) -> frozenset[str]:
    """The scalar inputs that the program reads."""
    return frozenset(str(node.name) for node in program.nodes if node.op is Op.INPUT)


def body_lines(program: Program, syntax: Syntax, store: Callable[[int], str], indent: str = "    ") -> list[str]:
    """Lines that load the inputs that are used, compute, and store output k at ``store(k)``.

    A line of the program gets a variable where it is used twice, has a name, or grows long; its name
    and its origin, as a comment, are those of the derivation. Where the syntax has ``turns``, sines and
    cosines that no other ones go into come first, all at once.
    """
    turned = angles_first(program) if syntax.turns else Turned(program, ())
    program = turned.program
    vectors = argument_names(program, syntax)
    names = Names({*syntax.reserved, *vectors})
    used = used_symbols(program)
    symbols: dict[str, str] = {}
    lines = []
    for vector, argument in zip(vectors, program.arguments, strict=True):
        for i, symbol in enumerate(argument.symbols):
            if symbol in used:
                symbols[symbol] = names.unique(symbol)
                lines.append(syntax.define(symbols[symbol], syntax.entry(vector, i)))
    uses = Counter([arg for node in program.nodes for arg in node.args])
    uses.update(program.outputs)
    texts: list[_Text] = []
    origin = ""
    for index, node in enumerate(program.nodes):
        if syntax.turns and turned.angles and index == turned.start:
            turns = {pair: names.unique(label) for pair, label in turned.labels.items()}
            targets = [turns.get((op, angle), "_") for angle in turned.angles for op in (Op.SIN, Op.COS)]
            lines.append(syntax.turns(targets, [texts[angle].text for angle in turned.angles]))
        if (node.op, *node.args) in turned.labels:
            texts.append(_Text(turns[node.op, node.args[0]]))
            continue
        text = _expression(node, texts, symbols, syntax)
        wanted = uses[index] > 1 or node.name or len(text.text) > LINE_WIDTH // 2
        if wanted and node.op not in NULLARY:
            if node.origin and node.origin != origin:
                origin = node.origin
                lines.append(syntax.comment(origin))
            name = names.unique(node.name or f"t{index}")
            lines.append(syntax.define(name, text.text))
            text = _Text(name)
        texts.append(text)
    lines.extend(syntax.store(store(k), texts[index].text) for k, index in enumerate(program.outputs))
    return [indent + line for line in lines]


def _expression(node: Node, texts: list[_Text], symbols: Mapping[str, str], syntax: Syntax) -> _Text:
    op, operands, value, name, _ = node
    args = [texts[i] for i in operands]
    infix = INFIX.get(op)
    if infix is not None:
        symbol, strength = infix
        # Operators group to the left: only the right operand needs care; (a + b) + c needs no brackets.
        left, right = args[0].inside(strength), args[1].inside(strength + 1)
        return _Text(f"{left}{symbol}{right}", strength)
    if value is not None:
        number = syntax.number(float(value))
        return _Text(number, UNARY if number.startswith("-") else ATOM)
    if not args:
        assert name is not None
        return _Text(symbols[name])
    if op is Op.NEG:
        return _Text(f"-{args[0].inside(ATOM)}", UNARY)  # -(-x): a double minus is another operator in C
    return _Text(f"{syntax.calls[op]}({', '.join([a.text for a in args])})")
