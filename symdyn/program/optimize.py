"""The pipeline of passes and its cost table."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from symdyn.program import passes
from symdyn.program.cost import Cost, count, weight
from symdyn.program.ssa import Program

Pass = Callable[[Program], Program]

DEFAULT: tuple[Pass, ...] = (
    passes.fold_constants,
    passes.collect_terms,
    passes.trigonometric,
    passes.factor_common,
    passes.share_subexpressions,
    passes.divide_to_reciprocal,
    passes.drop_dead,
)
# Jacobians of this many lines come from a program whose factors and angles were found already: there
# the other passes, and a second round, earned less than 0.1 %. Sharing collects terms on its way.
_LARGE = 2000
FOR_LARGE: tuple[Pass, ...] = (
    passes.share_subexpressions,
    passes.divide_to_reciprocal,
    passes.drop_dead,
)
_ROUNDS = 8
_WORTHWHILE = 0.005  # another round follows one that lowered the weight by this share or more


@dataclass(frozen=True, slots=True)
class CostRow:
    """The cost of a program after one pass; ``round`` counts from 1, and is 0 for the input.

    ``seconds`` of processor time is what the pass took: of no account in comparisons, and in no generated file.
    """

    pass_name: str
    round: int
    cost: Cost
    seconds: float = field(default=0.0, compare=False)


@dataclass(frozen=True, slots=True)
class Optimized:
    """A program after its passes, and what each of them earned."""

    program: Program
    costs: tuple[CostRow, ...]


def optimize(program: Program, passes: Sequence[Pass] | None = None) -> Optimized:
    """Run the passes in order, and again while a whole round lowers the weight by half a percent.

    ``passes``: DEFAULT, or where the program is large FOR_LARGE, and once.

    The cost table has a row for the input and for every pass of every round. The weight never rises
    from one row to the next.
    """
    rows = [CostRow("input", 0, count(program))]
    large = len(program.nodes) > _LARGE
    if passes is None:
        passes = FOR_LARGE if large else DEFAULT
    for turn in range(1, 2 if large else _ROUNDS + 1):
        before = weight(program)
        for step in passes:
            start = time.process_time()
            program = step(program)
            seconds = time.process_time() - start
            rows.append(CostRow(step.__name__, turn, count(program), seconds))
        if weight(program) >= before * (1.0 - _WORTHWHILE):
            break
    return Optimized(program, tuple(rows))


def notable(rows: Sequence[CostRow]) -> tuple[CostRow, ...]:
    """A cost table without the passes of later rounds that changed no count."""
    kept = [row for before, row in pairwise(rows) if row.round == 1 or row.cost != before.cost]
    return (*rows[:1], *kept)
