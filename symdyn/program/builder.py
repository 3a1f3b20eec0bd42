"""Builds programs with hash-consing: the same operation on the same lines is the same line."""

from __future__ import annotations

import math
from collections.abc import Iterable

from symdyn.program.errors import ProgramError
from symdyn.program.ssa import COMMUTATIVE, Argument, Node, Op, Program

_Key = tuple[Op, tuple[int, ...]]


class Builder:
    """Lines under construction, numbered by value; every pass writes through one."""

    def __init__(self) -> None:
        self._ops: list[Op] = []
        self._args: list[tuple[int, ...]] = []
        self._values: list[float | None] = []
        self._names: list[str | None] = []
        self._origins: list[str] = []
        self._lines: dict[_Key, int] = {}
        self._constants: dict[float, int] = {}
        self._inputs: dict[str, int] = {}
        self._labels: set[str] = set()

    def __len__(self) -> int:
        return len(self._ops)

    def op(self, line: int) -> Op:
        return self._ops[line]

    def args(self, line: int) -> tuple[int, ...]:
        return self._args[line]

    def value(self, line: int) -> float | None:
        """The number on the line, None unless it is a constant."""
        return self._values[line]

    def constant(self, value: float) -> int:
        """The line of a finite number; zero has no sign here."""
        if not math.isfinite(value):
            raise ProgramError("SD815", f"a constant must be finite, not {value}")
        number = float(value) + 0.0  # -0.0 becomes 0.0
        line = self._constants.get(number)
        if line is None:
            line = self._constants[number] = self._append(Op.CONST, (), number, None, "")
        return line

    def input(self, name: str) -> int:
        line = self._inputs.get(name)
        if line is None:
            line = self._inputs[name] = self._append(Op.INPUT, (), None, name, "")
        return line

    def intern(self, op: Op, args: tuple[int, ...], origin: str = "") -> int:
        """The line of ``op(args)``, made if it is new; arguments of commutative operations are ordered."""
        if op in COMMUTATIVE and args[0] > args[1]:
            args = (args[1], args[0])
        key = (op, args)
        line = self._lines.get(key)
        if line is None:
            line = self._lines[key] = self._append(op, args, None, None, origin)
        return line

    def label(self, line: int, name: str | None) -> None:
        """Name a line for people; the first name of a line and the first line of a name stay."""
        free = self._names[line] is None and self._ops[line] is not Op.CONST
        if name is not None and free and name not in self._labels:
            self._names[line] = name
            self._labels.add(name)

    def copy(self, node: Node, args: tuple[int, ...]) -> int:
        """The line of a node of another program whose arguments are ``args`` here, label included."""
        if node.op is Op.CONST:
            assert node.value is not None
            return self.constant(node.value)
        if node.op is Op.INPUT:
            assert node.name is not None
            return self.input(node.name)
        line = self.intern(node.op, args, node.origin)
        self.label(line, node.name)
        return line

    def program(
        self, name: str, arguments: tuple[Argument, ...], outputs: Iterable[int], shape: tuple[int, ...]
    ) -> Program:
        """The program that computes ``outputs``; lines that no output needs are left out."""
        wanted = tuple(outputs)
        live = [False] * len(self._ops)
        for line in wanted:
            live[line] = True
        for line in range(len(self._ops) - 1, -1, -1):
            if live[line]:
                for argument in self._args[line]:
                    live[argument] = True
        number = [0] * len(self._ops)
        nodes: list[Node] = []
        rows = zip(live, self._ops, self._args, self._values, self._names, self._origins, strict=True)
        for line, (is_live, op, args, value, label, origin) in enumerate(rows):
            if is_live:
                number[line] = len(nodes)
                nodes.append(Node(op, tuple([number[argument] for argument in args]), value, label, origin))
        return Program(name, arguments, tuple(nodes), tuple(number[line] for line in wanted), shape)

    def _append(self, op: Op, args: tuple[int, ...], value: float | None, name: str | None, origin: str) -> int:
        self._ops.append(op)
        self._args.append(args)
        self._values.append(value)
        self._names.append(name)
        self._origins.append(origin)
        return len(self._ops) - 1
