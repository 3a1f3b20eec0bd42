"""Solves symmetric positive definite systems inside a program: L D L^T, unrolled, zeros skipped."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.program.builder import Builder
from symdyn.program.ssa import Op

ORIGIN = "solve: L D L^T"


def solve_symmetric(builder: Builder, matrix: Sequence[Sequence[int]], right: Sequence[int]) -> tuple[int, ...]:
    """Lines of x with ``matrix @ x = right``; only the lower triangle of ``matrix`` (n, n) is read.

    No pivoting: a mass matrix is positive definite, else the robot was refused.
    """
    n = len(right)
    zero = builder.constant(0.0)

    def times(a: int, b: int) -> int:
        return zero if zero in (a, b) else builder.intern(Op.MUL, (a, b), ORIGIN)

    def minus(a: int, b: int) -> int:
        if b == zero:
            return a
        return builder.intern(Op.NEG, (b,), ORIGIN) if a == zero else builder.intern(Op.SUB, (a, b), ORIGIN)

    # Eliminated from the last coordinate to the first: chains of links and rotors then fill nothing in.
    lower = [[matrix[i][j] for j in range(i + 1)] for i in range(n)]
    pivots = [zero] * n
    factors = [[zero] * n for _ in range(n)]
    for k in range(n - 1, -1, -1):
        pivots[k] = lower[k][k]
        for i in range(k):
            if lower[k][i] != zero:
                factors[k][i] = builder.intern(Op.DIV, (lower[k][i], pivots[k]), ORIGIN)
        for i in range(k):
            for j in range(i + 1):
                lower[i][j] = minus(lower[i][j], times(factors[k][i], lower[k][j]))
    x = list(right)
    for k in range(n - 1, -1, -1):
        for i in range(k):
            x[i] = minus(x[i], times(factors[k][i], x[k]))
    x = [value if value == zero else builder.intern(Op.DIV, (value, pivots[k]), ORIGIN) for k, value in enumerate(x)]
    for k in range(n):
        for i in range(k):
            x[k] = minus(x[k], times(factors[k][i], x[i]))
    return tuple(x)
