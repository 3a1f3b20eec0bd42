"""The header and the source of a robot in C99: name tables, then every function, with parameters folded and as p."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable, Mapping, Sequence

from symdyn import __version__
from symdyn.base.wording import word_set
from symdyn.derive.equations import EquationsOfMotion
from symdyn.emit.c_functions import STACK, TEMPLATE, declarations, definitions
from symdyn.emit.c_helpers import helpers
from symdyn.emit.c_printer import C99, identifier, inside_comment, string
from symdyn.emit.forms import Form
from symdyn.emit.printer import argument_names
from symdyn.emit.tables import about, free_parameters, name_tables, parameter_values
from symdyn.emit.templates import render

TEMPLATES = ("c/header.h.j2", "c/source.c.j2", TEMPLATE)
COUNTED = ("COORDINATES", "STATES", "INPUTS", "OUTPUTS", "PARAMETERS")
WIDTH = 100

_STANDARD_HEADERS = word_set(
    """assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg stdatomic
    stdbit stdbool stdckdint stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype"""
)


def c_files(equations: EquationsOfMotion, forms: Sequence[Form]) -> Mapping[str, str]:
    """``<robot>.h`` and ``<robot>.c``; every name in them begins with ``<robot>_``."""
    prefix = identifier(equations.robot.name)
    stem = f"{prefix}_robot" if prefix in _STANDARD_HEADERS else prefix  # "math.h" would hide the other one
    title = _wrapped(about(equations))
    header = render(
        "c/header.h.j2",
        {
            "title": title,
            "version": __version__,
            "prefix": prefix,
            "stack": str(STACK // 1024),
            "note": _wrapped(_note(free_parameters(equations))),
            "guard": f"SYMDYN_{stem.upper()}_H",
            "tables": "\n".join(_declared_tables(equations, prefix)),
            "functions": "\n\n".join(_declaration(form, prefix) for form in forms),
        },
    )
    source = render(
        "c/source.c.j2",
        {
            "title": title,
            "version": __version__,
            "header": f"{stem}.h",
            "tables": "\n".join(_tables(equations, prefix)),
            "functions": "\n\n".join([*helpers(f.program for f in forms), *(definitions(f, prefix) for f in forms)]),
        },
    )
    return {f"{stem}.h": header, f"{stem}.c": source}


def _declared_tables(equations: EquationsOfMotion, prefix: str) -> Iterable[str]:
    tables = name_tables(equations)
    counts = ",\n".join(f"    {prefix}_n_{name.lower()} = {len(tables[name])}" for name in COUNTED)
    yield f"enum {{\n{counts}\n}};\n"
    yield f"extern const char {prefix}_robot[];"
    yield from (f"extern const char *const {prefix}_{name.lower()}[];" for name in tables)
    yield f"extern const double {prefix}_parameter_values[];"


def _tables(equations: EquationsOfMotion, prefix: str) -> Iterable[str]:
    tables = name_tables(equations)
    yield f"const char {prefix}_robot[] = {string(equations.robot.name)};"
    for name, entries in tables.items():
        yield f"const char *const {prefix}_{name.lower()}[] = {_braced([*map(string, entries), '0'])};"
    units = zip(tables["PARAMETERS"], tables["PARAMETER_UNITS"], strict=True)
    rows = [
        f"    {_number(value)}, /* {inside_comment(f'{name}, {unit}' if unit else name)} */"
        for value, (name, unit) in zip(parameter_values(equations), units, strict=True)
    ]
    # C has no empty arrays.
    yield "\n".join([f"const double {prefix}_parameter_values[] = {{", *(rows or ["    0.0, /* none */"]), "};"])


def _declaration(form: Form, prefix: str) -> str:
    program = form.program
    names = zip(argument_names(program, C99), program.arguments, strict=True)
    sizes = ", ".join(f"{name}[{len(argument.symbols)}]" for name, argument in names)
    rows = f", {' x '.join(map(str, program.shape))} row by row" if len(program.shape) > 1 else ""
    doc = f"/** {_wrapped(form.doc)}\n * {sizes} -> out[{len(program.outputs)}]{rows} */"
    return f"{doc}\n{declarations(form, prefix)}"


def _note(free: Sequence[str]) -> str:
    if not free:
        return "Tables give each vector's entries in order, with units."
    return f"Left free, hence no form with parameters folded in, and NAN in the table: {', '.join(free)}."


def _wrapped(text: str) -> str:
    """The text as lines of a comment that begins with ``/*``."""
    return "\n * ".join(textwrap.wrap(inside_comment(text), WIDTH, break_long_words=False))


def _braced(items: Sequence[str]) -> str:
    line = ", ".join(items)
    if len(line) <= WIDTH // 2:
        return f"{{{line}}}"
    rows = [""]
    for item in items:  # not textwrap: literals hold spaces
        if len(rows[-1]) + len(item) > WIDTH:
            rows.append("")
        rows[-1] += f" {item},"
    return "\n".join(["{", *(f"   {row}" for row in rows), "}"])


def _number(value: float) -> str:
    return "NAN" if math.isnan(value) else C99.number(value)
