"""Solves and inverts symmetric positive definite systems inside a program: L D L^T, unrolled, zeros skipped."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.program.builder import Builder
from symdyn.program.ssa import Op

ORIGIN = "solve: L D L^T"


def solve_symmetric(builder: Builder, matrix: Sequence[Sequence[int]], right: Sequence[int]) -> tuple[int, ...]:
    """Lines of x with ``matrix @ x = right``; only the lower triangle of ``matrix`` (n, n) is read.

    No pivoting: a mass matrix is positive definite, else the robot was refused.
    """
    work = Factors(builder, matrix)
    zero, n = work.zero, len(right)
    x = list(right)
    for k in range(n - 1, -1, -1):
        for i in range(k):
            x[i] = work.minus(x[i], work.times(work.below[k][i], x[k]))
    x = [v if v == zero else builder.intern(Op.DIV, (v, work.pivots[k]), ORIGIN) for k, v in enumerate(x)]
    for k in range(n):
        for i in range(k):
            x[k] = work.minus(x[k], work.times(work.below[k][i], x[i]))
    return tuple(x)


def invert_symmetric(builder: Builder, matrix: Sequence[Sequence[int]]) -> list[list[int]]:
    """Lines of the inverse (n, n), column by column: of each only what symmetry does not give already."""
    work = Factors(builder, matrix)
    n, one = len(matrix), builder.constant(1.0)
    inverse = [[work.zero] * n for _ in range(n)]
    for c in range(n):
        for k in range(c, n):
            # Row k of the unit vector, solved for all but the last factor, is 1 / pivot at c, and 0 below it.
            entry = builder.intern(Op.DIV, (one, work.pivots[c]), ORIGIN) if k == c else work.zero
            for i in range(k):
                entry = work.minus(entry, work.times(work.below[k][i], inverse[i][c]))
            inverse[k][c] = inverse[c][k] = entry
    return inverse


class Factors:
    """``matrix`` = F^T D F: ``pivots`` D, and ``below`` the diagonal F, whose diagonal is ones."""

    def __init__(self, builder: Builder, matrix: Sequence[Sequence[int]]) -> None:
        n = len(matrix)
        self.builder, self.zero = builder, builder.constant(0.0)
        self.pivots = [self.zero] * n
        self.below = [[self.zero] * n for _ in range(n)]
        # Eliminated from the last coordinate to the first: chains of links and rotors then fill nothing in.
        lower = [[matrix[i][j] for j in range(i + 1)] for i in range(n)]
        for k in range(n - 1, -1, -1):
            self.pivots[k] = lower[k][k]
            for i in range(k):
                if lower[k][i] != self.zero:
                    self.below[k][i] = builder.intern(Op.DIV, (lower[k][i], self.pivots[k]), ORIGIN)
            for i in range(k):
                for j in range(i + 1):
                    lower[i][j] = self.minus(lower[i][j], self.times(self.below[k][i], lower[k][j]))

    def times(self, a: int, b: int) -> int:
        return self.zero if self.zero in (a, b) else self.builder.intern(Op.MUL, (a, b), ORIGIN)

    def minus(self, a: int, b: int) -> int:
        if b == self.zero:
            return a
        return (
            self.builder.intern(Op.NEG, (b,), ORIGIN) if a == self.zero else self.builder.intern(Op.SUB, (a, b), ORIGIN)
        )
