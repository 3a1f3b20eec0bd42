"""A function that a kernel offers: a program with a sentence about it."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.program.columns import Columns
from symdyn.program.ssa import Program


@dataclass(frozen=True, slots=True)
class Function:
    """``program`` takes the parameter vector ``p`` as its last argument, until parameters are folded in.

    ``columns`` is the same in two steps, where it ends in a solve of many columns.
    """

    program: Program
    doc: str
    columns: Columns | None = None

    @property
    def name(self) -> str:
        return self.program.name
