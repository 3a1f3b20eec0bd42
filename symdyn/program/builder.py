"""Builds programs with hash-consing: the same operation on the same lines is the same line."""

from __future__ import annotations

import math
from collections.abc import Iterable

from symdyn.program.errors import ProgramError
from symdyn.program.ssa import COMMUTATIVE, Argument, Node, Op, Program

_Key = tuple[Op, tuple[int, ...]]


class Builder:
    """Lines under construction, numbered by value; every pass writes through one.

    ``ops``, ``args`` and ``values`` (None unless it is a constant) are by line, and only read from outside.
    """

    def __init__(self) -> None:
        self.ops: list[Op] = []
        self.args: list[tuple[int, ...]] = []
        self.values: list[float | None] = []
        self._names: list[str | None] = []
        self._origins: list[str] = []
        self._lines: dict[_Key, int] = {}
        self._constants: dict[float, int] = {}
        self._inputs: dict[str, int] = {}
        self._labels: set[str] = set()

    def __len__(self) -> int:
        return len(self.ops)

    def constant(self, value: float) -> int:
        """The line of a finite number; zero has no sign here."""
        line = self._constants.get(value)
        if line is None:
            if not math.isfinite(value):
                raise ProgramError("SD815", f"a constant must be finite, not {value}")
            number = float(value) + 0.0  # -0.0 becomes 0.0
            line = self._constants[number] = self._append(Op.CONST, (), number, None, "")
        return line

    def input(self, name: str) -> int:
        line = self._inputs.get(name)
        if line is None:
            line = self._inputs[name] = self._append(Op.INPUT, (), None, name, "")
        return line

    def intern(self, op: Op, args: tuple[int, ...], origin: str = "") -> int:
        """The line of ``op(args)``, made if it is new; arguments of commutative operations are ordered."""
        if len(args) == 2 and args[0] > args[1] and op in COMMUTATIVE:
            args = (args[1], args[0])
        key = (op, args)
        line = self._lines.get(key)
        if line is None:
            line = self._lines[key] = self._append(op, args, None, None, origin)
        return line

    def label(self, line: int, name: str | None) -> None:
        """Name a line for people; the first name of a line and the first line of a name stay."""
        if name is None or name in self._labels or self._names[line] is not None or self.values[line] is not None:
            return
        self._names[line] = name
        self._labels.add(name)

    def copy(self, node: Node, args: tuple[int, ...]) -> int:
        """The line of a node of another program whose arguments are ``args`` here, label included."""
        op, _, value, name, origin = node
        if args:
            line = self.intern(op, args, origin)
            if name is not None:
                self.label(line, name)
            return line
        if value is not None:
            return self.constant(value)
        assert name is not None
        return self.input(name)

    def program(
        self, name: str, arguments: tuple[Argument, ...], outputs: Iterable[int], shape: tuple[int, ...]
    ) -> Program:
        """The program that computes ``outputs``; lines that no output needs are left out."""
        wanted = tuple(outputs)
        args_of = self.args
        live = bytearray(len(args_of))
        for line in wanted:
            live[line] = 1
        for line in range(len(args_of) - 1, -1, -1):
            if live[line]:
                for argument in args_of[line]:
                    live[argument] = 1
        number = [0] * len(args_of)
        nodes: list[Node] = []
        rows = zip(live, self.ops, args_of, self.values, self._names, self._origins, strict=True)
        for line, (is_live, op, args, value, label, origin) in enumerate(rows):
            if is_live:
                number[line] = len(nodes)
                nodes.append(Node(op, tuple([number[argument] for argument in args]), value, label, origin))
        return Program(name, arguments, tuple(nodes), tuple([number[line] for line in wanted]), shape)

    def _append(self, op: Op, args: tuple[int, ...], value: float | None, name: str | None, origin: str) -> int:
        line = len(self.ops)
        self.ops.append(op)
        self.args.append(args)
        self.values.append(value)
        self._names.append(name)
        self._origins.append(origin)
        return line
