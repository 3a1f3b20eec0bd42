"""Like terms collected, signs moved to where a subtraction takes them up: a b + (-b) a is gone."""

from __future__ import annotations

from symdyn.program.cost import weight
from symdyn.program.polynomial_read import from_program
from symdyn.program.polynomial_write import to_program
from symdyn.program.ssa import Program

_TURNS = 4  # merging one chain may leave another with a single user, which then merges as well


def collect_terms(program: Program) -> Program:
    """The program through its polynomial view and back, again if that made it notably cheaper."""
    for _ in range(_TURNS):
        collected = to_program(from_program(program))
        before, after = weight(program), weight(collected)
        if after < before:
            program = collected
        if after > 0.99 * before:
            break
    return program
