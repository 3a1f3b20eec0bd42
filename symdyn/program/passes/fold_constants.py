"""Constants and neutral elements folded: numbers, x*0, x*1, x+0, x-x, signs into subtractions."""

from __future__ import annotations

from symdyn.program.cost import cheaper
from symdyn.program.folding import fold
from symdyn.program.passes.rebuild import rebuild
from symdyn.program.ssa import Program


def fold_constants(program: Program) -> Program:
    """Apply the local rules of ``folding`` to every line."""
    return cheaper(program, rebuild(program, lambda builder, node, args: fold(builder, node.op, args, node.origin)))
