"""What every target prints: each function optimised, once with its parameters folded in and once with a vector."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from symdyn.derive.equations import EquationsOfMotion
from symdyn.program.alike import Optimizer
from symdyn.program.columns import Columns
from symdyn.program.cost import count
from symdyn.program.functions import Function, fold_parameters
from symdyn.program.optimize import CostRow
from symdyn.program.ssa import Program


@dataclass(frozen=True, slots=True)
class Form:
    """A function as it is printed: NAME with numbers for parameters, or NAME_p with the vector ``p`` at the end.

    ``program.name`` is that of the function; ``costs`` is what each pass did to it. ``columns``, where there is one, is
    the same with its last step left to code that solves for many columns at once.
    """

    name: str
    doc: str
    program: Program
    costs: tuple[CostRow, ...]
    columns: Columns | None = None


def forms(equations: EquationsOfMotion, functions: Sequence[Function]) -> tuple[Form, ...]:
    """Both forms of every function, in order; folded ones are left out where a parameter is left free."""
    return tuple(_forms(equations, functions))


def _forms(equations: EquationsOfMotion, functions: Sequence[Function]) -> Iterator[Form]:
    values = [p.value for p in equations.robot.parameters]
    numbers = [value for value in values if value is not None and math.isfinite(value)]
    optimizer = Optimizer()
    for function in functions:
        if len(numbers) == len(values):
            yield _form(optimizer, fold_parameters(function, numbers), function.name, function.doc)
        yield _form(optimizer, function, f"{function.name}_p", f"{function.doc} Parameters from the vector p.")


def _form(optimizer: Optimizer, function: Function, name: str, doc: str) -> Form:
    if function.columns is None:
        optimized = optimizer.optimize(function.program)
        return Form(name, doc, optimized.program, optimized.costs)
    # The last step as it is: passes would make its columns unlike one another, and find nothing in it.
    optimized = optimizer.optimize(function.columns.head)
    columns = replace(function.columns, head=optimized.program)
    program = columns.whole()
    left = count(program) - count(optimized.program)
    return Form(name, doc, program, tuple(replace(row, cost=row.cost + left) for row in optimized.costs), columns)
