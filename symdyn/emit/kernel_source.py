"""The source of a kernel module: name tables, then every function in its four forms."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symdyn import __version__
from symdyn.derive.equations import EquationsOfMotion
from symdyn.emit.numba_printer import body_lines
from symdyn.emit.templates import render
from symdyn.program.functions import Function, fold_parameters
from symdyn.program.optimize import CostRow, optimize
from symdyn.program.ssa import Argument, Program


@dataclass(frozen=True, slots=True)
class KernelSource:
    """``text`` of kernel.py, and what each pass did to each function."""

    text: str
    costs: Mapping[str, tuple[CostRow, ...]]


def kernel_source(
    equations: EquationsOfMotion, functions: Sequence[Function], title: str | None = None
) -> KernelSource:
    """Print the functions as one module; folded forms are left out where a parameter is left free."""
    values = [math.nan if p.value is None else p.value for p in equations.robot.parameters]
    pieces, costs = [], {}
    for function in functions:
        forms = [(function, f"{function.name}_p", " Parameters from the vector p.")]
        if all(math.isfinite(value) for value in values):
            forms.insert(0, (fold_parameters(function, values), function.name, ""))
        for form, name, note in forms:
            optimized = optimize(form.program)
            costs[name] = optimized.costs
            pieces.append(_function(optimized.program, name, function.doc + note))
    tables = name_tables(equations, values)
    free = [p.name for p in equations.robot.parameters if p.value is None]
    text = render(
        "numba/kernel.py.j2",
        {
            "title": title or f"Kernel of {equations.robot.name}: {_plain(equations.robot.description)}",
            "version": __version__,
            "tables_doc": _tables_doc(free),
            "tables": tables,
            "functions": "\n\n".join(pieces).rstrip("\n"),
        },
    )
    return KernelSource(text, costs)


def name_tables(equations: EquationsOfMotion, values: Sequence[float]) -> str:
    """The constants of a kernel that say what each entry of each vector is, and its unit."""
    axes, robot = equations.axes, equations.robot
    rows = {
        "ROBOT": repr(robot.name),
        "COORDINATES": _tuple(a.address for a in axes),
        "COORDINATE_UNITS": _tuple(a.unit for a in axes),
        "EFFORT_UNITS": _tuple(a.effort_unit for a in axes),
        "STATES": _tuple(
            [f"{a.address}.q" for a in axes] + [f"{a.address}.qd" for a in axes] + [s.name for s in equations.states]
        ),
        "STATE_UNITS": _tuple(
            [a.unit for a in axes] + [f"{a.unit}/s" for a in axes] + [s.unit for s in equations.states]
        ),
        "INPUTS": _tuple(i.name for i in equations.inputs),
        "INPUT_UNITS": _tuple(i.unit for i in equations.inputs),
        "OUTPUTS": _tuple(s.name for s in equations.sensors),
        "OUTPUT_UNITS": _tuple(s.unit for s in equations.sensors),
        "PARAMETERS": _tuple(p.name for p in robot.parameters),
        "PARAMETER_UNITS": _tuple(p.unit for p in robot.parameters),
        "PARAMETER_VALUES": f"np.array([{', '.join(_number(v) for v in values)}])",
    }
    return "\n".join(f"{name} = {value}" for name, value in rows.items())


def _function(program: Program, name: str, doc: str) -> str:
    arguments = program.arguments
    shape = program.shape
    states = [a for a in arguments if a.name != "p"]
    store = _store(shape)
    body = body_lines(program, store)
    names = ", ".join(a.name for a in arguments)
    return render(
        "numba/function.py.j2",
        {
            "name": name,
            "arguments": names,
            "body": "\n".join(body),
            "doc": doc,
            "checks": "\n".join(_check(a) for a in arguments),
            "shape": repr(shape),
            "batch_checks": "\n".join(_batch_check(a, states[0]) for a in arguments),
            "batch_shape": f"({states[0].name}.shape[0], {', '.join(map(str, shape))})",
            "first": states[0].name,
            "batch_arguments": ", ".join(a.name if a.name == "p" else f"{a.name}[k]" for a in arguments),
        },
    )


def _store(shape: tuple[int, ...]):  # type: ignore[no-untyped-def]
    if len(shape) == 1:
        return lambda k: f"out[{k}]"
    return lambda k: f"out[{k // shape[1]}, {k % shape[1]}]"


def _check(argument: Argument) -> str:
    """Numba does not check bounds: a short array would be read past its end."""
    size = len(argument.symbols)
    return (
        f"    if {argument.name}.shape[0] != {size}:\n"
        f'        raise ValueError("{argument.name} must have {size} entries")'
    )


def _batch_check(argument: Argument, first: Argument) -> str:
    size = len(argument.symbols)
    if argument.name == "p":
        return _check(argument)
    if argument == first:
        return (
            f"    if {first.name}.shape[1] != {size}:\n"
            f'        raise ValueError("{first.name} must have {size} columns, a row per state")'
        )
    return (
        f"    if {argument.name}.shape[1] != {size} or {argument.name}.shape[0] != {first.name}.shape[0]:\n"
        f'        raise ValueError("{argument.name} must have as many rows as {first.name}, and {size} columns")'
    )


def _tables_doc(free: Sequence[str]) -> str:
    if not free:
        return "What each entry of each vector is stands in the tables below, with units."
    return f"Left free, hence no form with parameters folded in: {', '.join(free)}."


def _tuple(items) -> str:  # type: ignore[no-untyped-def]
    return repr(tuple(items))


def _number(value: float) -> str:
    return "np.nan" if math.isnan(value) else repr(float(value))


def _plain(text: str) -> str:
    """A user's sentence as part of a docstring: no quotes or backslashes that could end it."""
    return "".join(c for c in text if c.isprintable()).replace("\\", "/").replace('"', "'")
