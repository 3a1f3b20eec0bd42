"""What a program costs: the counts of the cost table, and one number that passes compare."""

from __future__ import annotations

from collections import Counter
from dataclasses import astuple, dataclass

from symdyn.program.ssa import NULLARY, Op, Program

_ADDITIONS = frozenset({Op.ADD, Op.SUB, Op.NEG})
_TRIGONOMETRIC = frozenset({Op.SIN, Op.COS, Op.TAN})

# Approximate costs in units of one addition, vectorised double precision on x86-64.
WEIGHTS = {Op.CONST: 0, Op.INPUT: 0, Op.DIV: 4, Op.SQRT: 5, Op.SIN: 20, Op.COS: 20, Op.TAN: 25} | {
    Op.TANH: 25, Op.EXP: 15, Op.LOG: 15, Op.ATAN2: 30
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Cost:
    """Operation counts; a change of sign counts as an addition; constants and inputs are free."""

    additions: int
    multiplications: int
    divisions: int
    trigonometric: int  # sin, cos, tan
    other: int  # all that remains: exp, sqrt, abs, sign, min, ...

    @property
    def lines(self) -> int:
        """All operations."""
        return self.additions + self.multiplications + self.divisions + self.trigonometric + self.other

    def __add__(self, other: Cost) -> Cost:
        return Cost(*(a + b for a, b in zip(astuple(self), astuple(other), strict=True)))

    def __sub__(self, other: Cost) -> Cost:
        return Cost(*(a - b for a, b in zip(astuple(self), astuple(other), strict=True)))


def count(program: Program) -> Cost:
    """Count the operations of a program."""
    times = _times(program)
    additions = sum(times[op] for op in _ADDITIONS)
    trigonometric = sum(times[op] for op in _TRIGONOMETRIC)
    known = additions + times[Op.MUL] + times[Op.DIV] + trigonometric + sum(times[op] for op in NULLARY)
    return Cost(additions, times[Op.MUL], times[Op.DIV], trigonometric, len(program.nodes) - known)


def weight(program: Program) -> int:
    """Estimated run time in units of one addition: what a pass must not raise."""
    return sum(times * WEIGHTS.get(op, 1) for op, times in _times(program).items())


def _times(program: Program) -> Counter[Op]:
    """How often each operation occurs."""
    return Counter([node[0] for node in program.nodes])


def cheaper(before: Program, after: Program) -> Program:
    """``after`` unless it costs more than ``before``."""
    return after if weight(after) <= weight(before) else before
