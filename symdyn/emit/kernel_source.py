"""The source of a kernel module: name tables, then every function in its forms."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate, pairwise
from types import MappingProxyType

from symdyn import __version__
from symdyn.derive.equations import EquationsOfMotion
from symdyn.emit.forms import Form
from symdyn.emit.numba_printer import body_lines, lines_before_columns
from symdyn.emit.printer import LINE_WIDTH, PARAMETERS
from symdyn.emit.tables import about, free_parameters, name_tables, parameter_values
from symdyn.emit.templates import render
from symdyn.program.columns import Columns
from symdyn.program.ssa import Argument

BLOCK = 32  # states that are computed together: their vectors stay in the first cache
SIDE = 8  # of the squares that rows are transposed by: as many doubles as the widest vector holds
TEMPLATES = ("numba/kernel.py.j2", "numba/function.py.j2", "numba/columns.py.j2")


def kernel_source(
    equations: EquationsOfMotion, forms: Sequence[Form], further: Mapping[str, str] = MappingProxyType({})
) -> str:
    """The text of kernel.py: the forms of all functions as one module; ``further`` constants by name."""
    pieces = [_function(form) for form in forms]
    return render(
        "numba/kernel.py.j2",
        {
            "title": about(equations),
            "version": __version__,
            "tables_doc": _tables_doc(free_parameters(equations)),
            "tables": _tables(equations, forms, further),
            "block": str(BLOCK),
            "functions": "\n\n".join(pieces).rstrip("\n"),
        },
    )


def _tables(equations: EquationsOfMotion, forms: Sequence[Form], further: Mapping[str, str]) -> str:
    """The constants of a kernel that say what each entry of each vector is, and its unit."""
    rows = {"ROBOT": repr(equations.robot.name)}
    rows |= {name: repr(entries) for name, entries in name_tables(equations).items()}
    rows["PARAMETER_VALUES"] = f"np.array([{', '.join(_number(v) for v in parameter_values(equations))}])"
    rows["SHAPES"] = "{\n" + "".join(f"    {name!r}: {shapes!r},\n" for name, shapes in _shapes(forms).items()) + "}"
    return "\n".join(f"{name} = {value}" for name, value in (rows | dict(further)).items())


def _shapes(forms: Sequence[Form]) -> dict[str, tuple[tuple[int, ...], ...]]:
    """Of every function the shapes of its arguments and, last, of its result."""
    return {form.name: (*((len(a.symbols),) for a in form.program.arguments), form.program.shape) for form in forms}


def _function(form: Form) -> str:
    program, name = form.program, form.name
    arguments = program.arguments
    states = [a for a in arguments if a.name != PARAMETERS]
    size, shape = math.prod(program.shape), program.shape
    flat = len(shape) == 1
    offsets = list(accumulate((len(a.symbols) for a in arguments), initial=0))
    vectors = [(a.name, len(a.symbols)) for a in states]
    return render(
        "numba/function.py.j2",
        {
            "name": name,
            "doc": form.doc,
            "body": "\n".join(body_lines(program) or ["    pass"]),
            "single": _single(form.columns, name) if form.columns else "",
            "of_one": f"_{name}_of_one" if form.columns else f"_{name}",
            "arguments": ", ".join(a.name for a in arguments),
            "first": states[0].name,
            "size": str(size),
            "checks": "\n".join(_check(a) for a in arguments),
            "row_checks": "\n".join(_batch_check(a, states[0], 0) for a in arguments),
            "column_checks": "\n".join(_batch_check(a, states[0], 1) for a in arguments),
            "tile": "\n".join(_tile([*vectors, ("out", size)])),
            "shape_rows": ", ".join(map(str, shape)),
            "packed_size": str(offsets[-1] + size),
            "packed_inputs": str(offsets[-1]),
            "packed_names": ", ".join(a.name for a in arguments),
            "packed_arguments": ", ".join(f"both[{i}:{j}]" for i, j in pairwise(offsets)),
            "shape": str(size) if flat else str(shape),
            "flat": "out" if flat else "_flat(out)",
            "out_checks": "\n".join(_out_checks(size, flat)),
            "scratch_arguments": _each(arguments, states, "{}_"),
            "arguments_flat": ", ".join([*(a.name for a in arguments), "flat"]),
            "flat_arguments": _each(arguments, states, "np.asarray({}, np.float64).ravel()"),
            "flattened": "\n".join(f"    {a.name} = np.asarray({a.name}, np.float64).ravel()" for a in states),
            "gather_rows": "\n".join(_squares("_gather", *vector) for vector in vectors if vector[1]),
            "scatter_rows": _squares("_scatter", "out", size),
            "gather_columns": "\n".join(line for vector in vectors for line in _gather_columns(*vector)),
            "reshape_rows": f".reshape((count, {', '.join(map(str, shape))}))",
            "reshape_columns": "" if flat else f".reshape(({', '.join(map(str, shape))}, count))",
        },
    )


def _single(columns: Columns, name: str) -> str:
    """The body for a single state, whose last step takes many columns at once."""
    body, numbers = lines_before_columns(columns)
    return render(
        "numba/columns.py.j2",
        {
            "name": name,
            "start": str(columns.start),
            "width": str(columns.width),
            "first": repr(columns.first),
            "places": _on_lines(columns.factors),
            "arguments": ", ".join(a.name for a in columns.head.arguments),
            "body": "\n".join(body),
            "numbers": _on_lines(numbers, "        "),
        },
    )


def _on_lines(items: Sequence[object], indent: str = "    ") -> str:
    """Items of a tuple, on lines of their own where one is too short for them."""
    text = "".join(f"{item}, " for item in items).rstrip()
    if len(text) <= LINE_WIDTH:
        return text
    lines = [""]
    for item in items:
        if len(lines[-1]) + len(f"{item}, ") > LINE_WIDTH:
            lines.append("")
        lines[-1] += f"{item}, "
    return "\n" + "\n".join(f"{indent}{line.rstrip()}" for line in lines)


def _out_checks(size: int, flat: bool) -> Iterator[str]:
    yield f'    if out.size != {size}:\n        raise ValueError("out must have {size} entries")'
    if not flat:  # what is not contiguous would be copied, and the copy written to
        yield '    if not out.flags.c_contiguous:\n        raise ValueError("out must be contiguous")'


def _each(arguments: Sequence[Argument], states: Sequence[Argument], text: str) -> str:
    """The arguments of a call, with ``text`` around the names of those that differ from state to state."""
    return ", ".join(text.format(a.name) if a in states else a.name for a in arguments)


def _tile(vectors: Sequence[tuple[str, int]]) -> Iterator[str]:
    """Scratch for a block, a line per entry. One array: LLVM then sees that its parts do not overlap."""
    offsets = list(accumulate((BLOCK * size for _, size in vectors), initial=0))
    yield "    _align_stack()"
    yield f"    tile = np.zeros({offsets[-1]})"
    for (name, _), (start, stop) in zip(vectors, pairwise(offsets), strict=True):
        yield f"    {name}_ = tile[{start}:{stop}]"


def _squares(move: str, name: str, size: int) -> str:
    """Moves eight states between rows and the tile, by squares; the last one overlaps the one before to stay inside."""
    call = f"{move}({name}, {size}, {{}}, {{}}, start + j, last - 1, {name}_, j)"
    if size <= SIDE:
        return f"            {call.format(0, size)}"
    last = f"min(i, {size - SIDE})"
    return f"            for i in range(0, {size}, {SIDE}):\n                {call.format(last, SIDE)}"


def _gather_columns(name: str, size: int) -> Iterator[str]:
    yield f"        for i in range({size}):"
    yield f"            line = {name}[i, start:start + here]"
    yield "            for j in range(here):"
    yield f"                {name}_[{BLOCK} * i + j] = line[j]"


def _check(argument: Argument) -> str:
    """Numba does not check bounds: a short array would be read past its end."""
    size = len(argument.symbols)
    return (
        f"    if {argument.name}.shape[0] != {size}:\n"
        f'        raise ValueError("{argument.name} must have {size} entries")'
    )


def _batch_check(argument: Argument, first: Argument, along: int) -> str:
    """States run along axis ``along``: rows or columns."""
    size, name = len(argument.symbols), argument.name
    if name == PARAMETERS:
        return _check(argument)
    state, entry = (("row", "column"), ("column", "row"))[along]
    test = f"{name}.shape[{1 - along}] != {size}"
    if argument == first:
        message = f"{name} must have {size} {entry}s, a {state} per state"
    else:
        test += f" or {name}.shape[{along}] != {first.name}.shape[{along}]"
        message = f"{name} must have as many {state}s as {first.name}, and {size} {entry}s"
    return f'    if {test}:\n        raise ValueError("{message}")'


def _tables_doc(free: Sequence[str]) -> str:
    if not free:
        return "What each entry of each vector is stands in the tables below, with units."
    return f"Left free, hence no form with parameters folded in: {', '.join(free)}."


def _number(value: float) -> str:
    return "np.nan" if math.isnan(value) else repr(float(value))
