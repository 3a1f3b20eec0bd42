"""Like terms collected, signs moved to where a subtraction takes them up: a b + (-b) a is gone."""

from __future__ import annotations

from symdyn.program.cost import cheaper
from symdyn.program.polynomial_read import from_program
from symdyn.program.polynomial_write import to_program
from symdyn.program.ssa import Program


def collect_terms(program: Program) -> Program:
    """The program through its polynomial view and back."""
    return cheaper(program, to_program(from_program(program)))
