"""Numba's syntax: what the functions of a kernel are made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from symdyn.emit import printer
from symdyn.emit.printer import PARAMETERS, Syntax
from symdyn.program.columns import Columns
from symdyn.program.ssa import Op, Program

NUMBA = Syntax(
    calls={
        Op.SIN: "_sin",
        Op.COS: "_cos",
        Op.TAN: "math.tan",
        Op.TANH: "math.tanh",
        Op.EXP: "math.exp",
        Op.LOG: "math.log",
        Op.SQRT: "math.sqrt",
        Op.ATAN2: "math.atan2",
        Op.ABS: "abs",
        Op.SIGN: "_sign",
        Op.STEP: "_step",
        Op.MIN: "min",
        Op.MAX: "max",
        Op.FLOOR: "np.floor",
    },
    reserved=frozenset(
        {"out", "math", "np", "k", "S", "turns", "_", "abs", "min", "max", "_sign", "_step", "_sin", "_cos"}
    ),
    define="{} = {}".format,
    store="{} = {}".format,
    comment="# {}".format,
    entry=lambda vector, i: f"{vector}[{i}]" if vector == PARAMETERS else f"{vector}[{i} * S + k]",
    turns=lambda names, angles: f"{', '.join(names)} = turns(({', '.join(angles)},))",
)

OUT: Callable[[int], str] = "out[{} * S + k]".format


def body_lines(program: Program, indent: str = "    ") -> list[str]:
    """Lines that load the inputs that are used, compute, and store the outputs.

    Entry i of a vector is at ``i * S + k``: that of state k among S, or with S = 1, k = 0 of a single one. ``turns``
    gives sines and cosines of a tuple of angles: in one vector, or one by one where a loop over k has the vectors.
    """
    return printer.body_lines(program, NUMBA, OUT, indent)


def lines_before_columns(columns: Columns, indent: str = "    ") -> tuple[list[str], list[str]]:
    """The same for all but the last step; and the names of what that step takes, factors and then reciprocals."""
    end, head = columns.end, columns.head
    factors = {end + k * (k - 1) // 2 + i: f"factor_{k}_{i}" for k, i in columns.factors}
    names = factors | {len(head.outputs) - columns.size + k: f"reciprocal_{k}" for k in range(columns.size)}
    kept = [*range(end), *names]
    places = [*map(OUT, range(end)), *names.values()]
    syntax = replace(NUMBA, reserved=NUMBA.reserved | set(names.values()))
    shorter = replace(head, outputs=tuple(head.outputs[k] for k in kept), shape=(len(kept),))
    return printer.body_lines(shorter, syntax, places.__getitem__, indent), [*names.values()]
