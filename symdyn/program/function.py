"""A function that a kernel offers: a program with a sentence about it."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.program.ssa import Program


@dataclass(frozen=True, slots=True)
class Function:
    """``program`` takes the parameter vector ``p`` as its last argument, until parameters are folded in."""

    program: Program
    doc: str

    @property
    def name(self) -> str:
        return self.program.name
