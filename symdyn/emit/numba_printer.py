"""Prints a program as the lines of a Numba function body: named intermediates, short expressions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from symdyn.program.ssa import Node, Op, Program

ADDITIVE, MULTIPLICATIVE, UNARY, ATOM = range(1, 5)  # binding strength, as in Python's grammar
LINE_WIDTH = 100

INFIX: dict[Op, tuple[str, int]] = {
    Op.ADD: (" + ", ADDITIVE),
    Op.SUB: (" - ", ADDITIVE),
    Op.MUL: (" * ", MULTIPLICATIVE),
    Op.DIV: (" / ", MULTIPLICATIVE),
}
CALLS: dict[Op, str] = {
    Op.SIN: "math.sin",
    Op.COS: "math.cos",
    Op.TAN: "math.tan",
    Op.TANH: "math.tanh",
    Op.EXP: "math.exp",
    Op.LOG: "math.log",
    Op.SQRT: "math.sqrt",
    Op.ATAN2: "math.atan2",
    Op.ABS: "abs",
    Op.SIGN: "_sign",
    Op.STEP: "_step",
    Op.MIN: "min",
    Op.MAX: "max",
}


class _Text:
    """An expression being built: its text and how tightly it binds."""

    __slots__ = ("strength", "text")

    def __init__(self, text: str, strength: int = ATOM) -> None:
        self.text, self.strength = text, strength

    def inside(self, strength: int) -> str:
        return self.text if self.strength >= strength else f"({self.text})"


def body_lines(program: Program, store: Callable[[int], str], indent: str = "    ") -> list[str]:
    """Lines that load the inputs that are used, compute, and store output k at ``store(k)``."""
    uses = Counter(arg for node in program.nodes for arg in node.args)
    uses.update(program.outputs)
    used_inputs = {node.name for node in program.nodes if node.op is Op.INPUT}
    lines = [
        f"{indent}{symbol} = {argument.name}[{i}]"
        for argument in program.arguments
        for i, symbol in enumerate(argument.symbols)
        if symbol in used_inputs
    ]
    names = _Names(used_inputs)
    texts: list[_Text] = []
    origin = ""
    for node in program.nodes:
        text = _expression(node, texts)
        index = len(texts)
        atom = node.op in (Op.CONST, Op.INPUT)
        if not atom and (uses[index] > 1 or node.name or len(text.text) > LINE_WIDTH // 2):
            if node.origin and node.origin != origin:
                origin = node.origin
                lines.append(f"{indent}# {origin}")
            name = names.unique(node.name or f"t{index}")
            lines.append(f"{indent}{name} = {text.text}")
            text = _Text(name)
        texts.append(text)
    lines.extend(f"{indent}{store(k)} = {texts[index].text}" for k, index in enumerate(program.outputs))
    return lines


def _expression(node: Node, texts: list[_Text]) -> _Text:
    if node.op is Op.CONST:
        assert node.value is not None
        return _Text(repr(node.value), UNARY if node.value < 0 else ATOM)
    if node.op is Op.INPUT:
        assert node.name is not None
        return _Text(node.name)
    args = [texts[i] for i in node.args]
    if node.op is Op.NEG:
        return _Text(f"-{args[0].inside(UNARY)}", UNARY)
    if node.op in INFIX:
        symbol, strength = INFIX[node.op]
        # Python groups to the left: only the right operand needs care; (a + b) + c needs no brackets.
        left, right = args[0].inside(strength), args[1].inside(strength + 1)
        return _Text(f"{left}{symbol}{right}", strength)
    return _Text(f"{CALLS[node.op]}({', '.join(a.text for a in args)})")


class _Names:
    """Hands out variable names, each once."""

    def __init__(self, taken: set[str | None]) -> None:
        self._taken = {"out", "math", "np", "k", *(name for name in taken if name)}

    def unique(self, wanted: str) -> str:
        name, count = wanted, 1
        while name in self._taken:
            count += 1
            name = f"{wanted}_{count}"
        self._taken.add(name)
        return name
