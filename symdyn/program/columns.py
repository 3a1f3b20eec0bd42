"""A program that ends by solving one symmetric system for many columns: written out, or left to vector instructions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from symdyn.program.builder import Builder
from symdyn.program.compose import inline
from symdyn.program.folding import fold
from symdyn.program.solve import ORIGIN, Factors
from symdyn.program.ssa import Argument, Op, Program
from symdyn.program.substitute import bind

WIDE = 8  # columns from which on they fill a vector: fewer are not worth a code of their own


@dataclass(frozen=True, slots=True)
class Columns:
    """``head`` computes all but the last step, X with F^T D F X = B, in which every column of B sees the same.

    Outputs of ``head``: those of the function (``shape``), in which from ``start`` on there are the ``size`` rows of B
    of ``width`` in place of X; then F below its diagonal, row by row, whose diagonal is ones; then 1 / D.
    """

    head: Program
    shape: tuple[int, ...]
    start: int
    size: int
    width: int

    @property
    def wide(self) -> bool:
        """Whether the columns fill a vector, and enough is left to be done to them: a factor for every row."""
        return self.width >= WIDE and len(self.factors) >= self.size

    @property
    def end(self) -> int:
        """Where the outputs of the function end, and the factors begin."""
        return len(self.head.outputs) - self.size * (self.size + 1) // 2

    @property
    def factors(self) -> tuple[tuple[int, int], ...]:
        """Row and column of those that are not zero by structure."""
        below = [(k, i) for k in range(self.size) for i in range(k)]
        return tuple(place for j, place in enumerate(below) if self._filled(self.end + j))

    @property
    def first(self) -> tuple[int, ...]:
        """Of each row of B the first column that is not zero by structure; ``width`` where there is none."""
        rows = [range(self.start + i * self.width, self.start + (i + 1) * self.width) for i in range(self.size)]
        return tuple(next((k - row.start for k in row if self._filled(k)), self.width) for row in rows)

    def _filled(self, output: int) -> bool:
        return self.head.nodes[self.head.outputs[output]].value != 0.0

    def bound(self, values: Mapping[str, float], drop: Sequence[str]) -> Columns:
        """With inputs fixed, as ``bind`` does it."""
        return replace(self, head=bind(self.head, values, drop=drop))

    def whole(self) -> Program:
        """The function as one program, with the solve written out and zeros skipped."""
        builder = Builder()
        lines = list(inline(builder, self.head))
        below, reciprocals = lines[self.end : -self.size], lines[-self.size :]

        def less(x: int, factor: int, other: int) -> int:
            return fold(builder, Op.SUB, (x, fold(builder, Op.MUL, (factor, other), ORIGIN)), ORIGIN)

        for c in range(self.width):
            places = [self.start + i * self.width + c for i in range(self.size)]
            x = [lines[place] for place in places]
            for k in range(self.size - 1, -1, -1):
                for i in range(k):
                    x[i] = less(x[i], below[k * (k - 1) // 2 + i], x[k])
            x = [fold(builder, Op.MUL, pair, ORIGIN) for pair in zip(x, reciprocals, strict=True)]
            for k in range(self.size):
                for i in range(k):
                    x[k] = less(x[k], below[k * (k - 1) // 2 + i], x[i])
            for place, line in zip(places, x, strict=True):
                lines[place] = line
        return builder.program(self.head.name, self.head.arguments, lines[: self.end], self.shape)


def columns(
    builder: Builder,
    name: str,
    arguments: tuple[Argument, ...],
    matrix: Sequence[Sequence[int]],
    right: Sequence[Sequence[int]],
    before: Sequence[int] = (),
    after: Sequence[int] = (),
) -> Columns:
    """The solution of ``matrix @ x = right`` (the matrix symmetric, by rows; ``right`` column by column), between other
    rows of a function with as many columns.
    """
    factors, one = Factors(builder, matrix), builder.constant(1.0)
    size, width = len(matrix), len(right)
    outputs = [*before, *(column[i] for i in range(size) for column in right), *after]
    below = [factors.below[k][i] for k in range(size) for i in range(k)]
    reciprocals = [fold(builder, Op.DIV, (one, pivot), ORIGIN) for pivot in factors.pivots]
    everything = [*outputs, *below, *reciprocals]
    head = builder.program(name, arguments, everything, (len(everything),))
    rows = size + (len(before) + len(after)) // max(width, 1)
    return Columns(head, (rows, width), len(before), size, width)
