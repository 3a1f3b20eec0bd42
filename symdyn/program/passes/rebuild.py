"""The loop that passes over single lines have in common."""

from __future__ import annotations

from collections.abc import Callable

from symdyn.program.builder import Builder
from symdyn.program.ssa import NULLARY, Node, Program


def rebuild(program: Program, make: Callable[[Builder, Node, tuple[int, ...]], int]) -> Program:
    """Write the program again, each operation by ``make(builder, node, arguments)``; dead lines are left out."""
    builder, lines = Builder(), list[int]()
    for node in program.nodes:
        args = tuple(lines[argument] for argument in node.args)
        line = builder.copy(node, args) if node.op in NULLARY else make(builder, node, args)
        builder.label(line, node.name)
        lines.append(line)
    return builder.program(program.name, program.arguments, [lines[o] for o in program.outputs], program.shape)
