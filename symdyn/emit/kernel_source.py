"""The source of a kernel module: name tables, then every function in its four forms."""

from __future__ import annotations

import math
from collections.abc import Sequence

from symdyn import __version__
from symdyn.derive.equations import EquationsOfMotion
from symdyn.emit.forms import Form
from symdyn.emit.numba_printer import body_lines
from symdyn.emit.tables import about, free_parameters, name_tables, parameter_values
from symdyn.emit.templates import render
from symdyn.program.ssa import Argument, Program

TEMPLATES = ("numba/kernel.py.j2", "numba/function.py.j2")


def kernel_source(equations: EquationsOfMotion, forms: Sequence[Form]) -> str:
    """The text of kernel.py: the forms of all functions as one module."""
    pieces = [_function(form.program, form.name, form.doc) for form in forms]
    return render(
        "numba/kernel.py.j2",
        {
            "title": about(equations),
            "version": __version__,
            "tables_doc": _tables_doc(free_parameters(equations)),
            "tables": _tables(equations),
            "functions": "\n\n".join(pieces).rstrip("\n"),
        },
    )


def _tables(equations: EquationsOfMotion) -> str:
    """The constants of a kernel that say what each entry of each vector is, and its unit."""
    rows = {"ROBOT": repr(equations.robot.name)}
    rows |= {name: repr(entries) for name, entries in name_tables(equations).items()}
    rows["PARAMETER_VALUES"] = f"np.array([{', '.join(_number(v) for v in parameter_values(equations))}])"
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


def _number(value: float) -> str:
    return "np.nan" if math.isnan(value) else repr(float(value))
