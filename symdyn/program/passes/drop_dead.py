"""Dead code: lines that no output needs are dropped, equal lines merged; usually there are none."""

from __future__ import annotations

from symdyn.program.builder import Builder
from symdyn.program.passes.rebuild import rebuild
from symdyn.program.ssa import NULLARY, Program


def drop_dead(program: Program) -> Program:
    """Only the lines that the outputs need, and each once."""
    used = set(program.outputs)
    for node in program.nodes:
        used.update(node.args)
    distinct = {(node.op, node.args, node.value, node.name if node.op in NULLARY else None) for node in program.nodes}
    return program if len(used) == len(distinct) == len(program.nodes) else rebuild(program, Builder.copy)
