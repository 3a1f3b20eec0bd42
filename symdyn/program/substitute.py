"""Inputs replaced by numbers: parameters folded in, or accelerations set to zero."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from symdyn.program.builder import Builder
from symdyn.program.errors import ProgramError
from symdyn.program.folding import fold
from symdyn.program.ssa import NULLARY, Op, Program


def bind(program: Program, values: Mapping[str, float], name: str | None = None, drop: Collection[str] = ()) -> Program:
    """The program with the named inputs fixed and folded.

    Arguments keep all their entries, except those named in ``drop``, which leave the signature whole.
    Raises ProgramError (SD814) for a name that is no input, or a dropped argument with a free entry.
    """
    _refuse(program, "input", set(values) - set(program.symbols))
    _refuse(program, "argument", set(drop) - {argument.name for argument in program.arguments})
    dropped = [s for argument in program.arguments if argument.name in drop for s in argument.symbols]
    free = [symbol for symbol in dropped if symbol not in values]
    if free:
        raise ProgramError("SD814", f"program {program.name!r}: cannot drop {', '.join(free)}, which has no value")

    builder, lines = Builder(), list[int]()
    for node in program.nodes:
        args = tuple(lines[argument] for argument in node.args)
        value = values.get(node.name) if node.op is Op.INPUT and node.name is not None else None
        if value is not None:
            lines.append(builder.constant(float(value)))
        elif node.op in NULLARY:
            lines.append(builder.copy(node, args))
        else:
            lines.append(fold(builder, node.op, args, node.origin))
            builder.label(lines[-1], node.name)
    arguments = tuple(argument for argument in program.arguments if argument.name not in drop)
    outputs = [lines[output] for output in program.outputs]
    return builder.program(name or program.name, arguments, outputs, program.shape)


def _refuse(program: Program, what: str, unknown: set[str]) -> None:
    if unknown:
        raise ProgramError("SD814", f"program {program.name!r} has no {what} {', '.join(sorted(unknown))}")
