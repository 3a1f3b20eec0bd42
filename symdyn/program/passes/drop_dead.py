"""Dead code: lines that no output needs are dropped, equal lines merged."""

from __future__ import annotations

from symdyn.program.builder import Builder
from symdyn.program.passes.rebuild import rebuild
from symdyn.program.ssa import Program


def drop_dead(program: Program) -> Program:
    """Only the lines that the outputs need."""
    return rebuild(program, Builder.copy)
