"""The command cost: what the functions of a kernel cost, and what each pass of the optimiser earned and took."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from symdyn import compiler
from symdyn.base.errors import Problem, UsageError
from symdyn.base.wording import did_you_mean, quoted
from symdyn.faces.console import out, print_json, print_table
from symdyn.program.cost import Cost
from symdyn.program.optimize import CostRow
from symdyn.spec.urdf_chain import Chain

_COLUMNS = ("add", "mul", "div", "trig", "other", "ms")


def cost(model: str, chain: Chain, function: str | None, json: bool) -> None:
    robot = compiler.load_robot(model, chain)
    forms = compiler.compile_robot(robot).forms
    if function is not None:
        found = [form for form in forms if form.name == function]
        if not found:
            hint = did_you_mean(function, [form.name for form in forms])
            raise UsageError(Problem("SD306", f"the kernel has no function {quoted(function)}", hint=hint))
        forms = tuple(found)
    if json:
        print_json([{"function": form.name, "passes": [_facts(row) for row in form.costs]} for form in forms])
        return
    if function is not None:
        rows = [(_name(row), *_counts(row.cost), _milliseconds([row])) for row in forms[0].costs]
        print_table(f"{robot.name}: {function} after each pass", ("pass", *_COLUMNS), rows, "pass")
        return
    rows = [(form.name, *_counts(form.costs[-1].cost), _milliseconds(form.costs)) for form in forms]
    print_table(
        f"{robot.name}: operations of each function, and time to optimise it", ("function", *_COLUMNS), rows, "function"
    )
    everything = [row for form in forms for row in form.costs]
    out.print(f"all functions: {_milliseconds(everything)} ms", markup=False)


def _facts(row: CostRow) -> dict[str, Any]:
    return {"pass": row.pass_name, "round": row.round, **asdict(row.cost), "milliseconds": 1000 * row.seconds}


def _name(row: CostRow) -> str:
    return row.pass_name if row.round < 2 else f"{row.pass_name}, round {row.round}"


def _counts(cost: Cost) -> tuple[str, ...]:
    return tuple(str(number) for number in asdict(cost).values())


def _milliseconds(rows: Sequence[CostRow]) -> str:
    return f"{1000 * sum(row.seconds for row in rows):.1f}"
