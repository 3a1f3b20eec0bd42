"""Puts programs into one another: the outputs of one become inputs of the next."""

from __future__ import annotations

from collections.abc import Mapping

from symdyn.program.builder import Builder
from symdyn.program.ssa import Op, Program


def inline(builder: Builder, program: Program, given: Mapping[str, int] | None = None) -> tuple[int, ...]:
    """Copy a program into a builder; inputs named in ``given`` are replaced by those lines. Returns its outputs."""
    replaced = given or {}
    lines: list[int] = []
    for node in program.nodes:
        if node.op is Op.INPUT and node.name is not None and node.name in replaced:
            lines.append(replaced[node.name])
        else:
            lines.append(builder.copy(node, tuple(lines[i] for i in node.args)))
    return tuple(lines[i] for i in program.outputs)
