"""The forms of a function as C99: for one state, for rows of states, and for columns of states."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.emit.c_printer import C99, body_lines
from symdyn.emit.forms import Form
from symdyn.emit.printer import PARAMETERS, argument_names
from symdyn.emit.templates import render
from symdyn.program.ssa import Argument, Program

BLOCKS = (32, 16, 8, 4, 2, 1)  # states that are computed together, as many of them as the stack may hold
STACK = 64 * 1024  # bytes of all blocks of one call
TEMPLATE = "c/function.c.j2"


def declarations(form: Form, prefix: str) -> str:
    """Prototypes. They leave ``restrict`` out, which C++ does not have; in C, both are the same type."""
    name, vectors = f"{prefix}_{form.name}", _parameters(form.program)
    return "\n".join(
        [
            f"void {name}({vectors});",
            f"void {name}_batch(size_t count, {vectors});",
            f"void {name}_soa(size_t count, {vectors});",
        ]
    )


def definitions(form: Form, prefix: str) -> str:
    """All of them around one body: with S = 1 it serves one state, else a loop without a branch."""
    program, block = form.program, block_of(form.program)
    named = list(zip(argument_names(program, C99), program.arguments, strict=True))
    states = [(name, argument) for name, argument in named if argument.name != PARAMETERS]
    count = len(program.outputs)
    data = {
        "name": f"{prefix}_{form.name}",
        "parameters": _parameters(program, "restrict "),
        "arguments": ", ".join([*(name for name, _ in named), "out"]),
        "body": "\n".join(body_lines(program)),
        "S": str(block),
        "scratch": _scratch(states, count, block),
        "blocks": ", ".join([*(n if a.name == PARAMETERS else f"{n}_" for n, a in named), "out_"]),
        "outputs": str(count),
        "take_rows": _lines("take_rows({0}_, {1}, {0} + {2} * start, states, {2});", states, block),
        "take_columns": _lines("take_columns({0}_, {1}, {0} + start, states, {2}, count);", states, block),
    }
    return render(TEMPLATE, data).rstrip("\n")


def block_of(program: Program) -> int:
    """The states of a block: their vectors, in and out, take no more than STACK bytes."""
    entries = len(program.outputs) + sum(len(a.symbols) for a in program.arguments if a.name != PARAMETERS)
    return next((size for size in BLOCKS if 8 * size * entries <= STACK), 1)


def _parameters(program: Program, restrict: str = "") -> str:
    vectors = [f"const double *{restrict}{name}" for name in argument_names(program, C99)]
    return ", ".join([*vectors, f"double *{restrict}out"])


def _scratch(states: Sequence[tuple[str, Argument]], outputs: int, block: int) -> str:
    """Zeros where a last block has fewer states; C has no empty arrays."""
    vectors = [f"{name}_[{block * max(1, len(argument.symbols))}] = {{0.0}}" for name, argument in states]
    return "    double " + ", ".join([*vectors, f"out_[{block * max(1, outputs)}]"]) + ";"


def _lines(line: str, states: Sequence[tuple[str, Argument]], block: int) -> str:
    return "\n".join(f"        {line.format(name, block, len(argument.symbols))}" for name, argument in states)
