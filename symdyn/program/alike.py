"""Programs that differ in the names of their inputs alone are optimised once.

Without drives the derivative of the state is forward dynamics under another name, beside entries that are inputs
or numbers themselves; the same holds for their Jacobians.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace

from symdyn.program.builder import Builder
from symdyn.program.compose import inline
from symdyn.program.optimize import Optimized, optimize
from symdyn.program.ssa import COMMUTATIVE, NULLARY, Op, Program


class Optimizer:
    """``optimize`` with a memory of the programs that it has seen."""

    def __init__(self) -> None:
        self._known: dict[Hashable, tuple[_Outline, Optimized]] = {}

    def optimize(self, program: Program) -> Optimized:
        outline = _outline(program)
        known = self._known.get(outline.key)
        if known is None:
            result = optimize(program)
            self._known[outline.key] = outline, result
            return result
        other, result = known
        costs = tuple(replace(row, seconds=0.0) for row in result.costs)
        return Optimized(_renamed(program, outline, other, result.program), costs)


@dataclass(frozen=True, slots=True)
class _Outline:
    key: Hashable  # what is computed, whatever the inputs are called
    inputs: tuple[str, ...]  # their names, in the order of their first use
    computed: tuple[int, ...]  # the outputs that are neither an input nor a number, by place


def _outline(program: Program) -> _Outline:
    nodes = program.nodes
    number: dict[int, int] = {}  # of each line in the key: inputs and numbers stand where they are first used
    inputs: list[str] = []
    rows: list[Hashable] = []
    for line, (op, args, _, label, origin) in enumerate(nodes):
        if op in NULLARY:
            continue
        for argument in args:
            if argument not in number:
                number[argument] = len(rows)
                rows.append(nodes[argument].value)  # None for an input
                if nodes[argument].op is Op.INPUT:
                    inputs.append(str(nodes[argument].name))
        own = tuple([number[argument] for argument in args])
        number[line] = len(rows)
        rows.append((op, tuple(sorted(own)) if op in COMMUTATIVE else own, label, origin))
    computed = tuple(place for place, output in enumerate(program.outputs) if nodes[output].op not in NULLARY)
    key = (tuple(rows), tuple([number[program.outputs[place]] for place in computed]))
    return _Outline(key, tuple(inputs), computed)


def _renamed(program: Program, outline: _Outline, other: _Outline, optimized: Program) -> Program:
    """``program`` from the optimised form of its like."""
    builder = Builder()
    given = {old: builder.input(new) for old, new in zip(other.inputs, outline.inputs, strict=True)}
    lines = inline(builder, optimized, given)
    computed = dict(zip(outline.computed, (lines[place] for place in other.computed), strict=True))
    outputs = [
        computed[place] if place in computed else builder.copy(program.nodes[output], ())
        for place, output in enumerate(program.outputs)
    ]
    return builder.program(program.name, program.arguments, outputs, program.shape)
