"""Numba's syntax: what the functions of a kernel are made of."""

from __future__ import annotations

from symdyn.emit import printer
from symdyn.emit.printer import Syntax
from symdyn.program.ssa import Op, Program

PARAMETERS = "p"  # the vector that all states of a batch share

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
    reserved=frozenset({"out", "math", "np", "k", "S", "abs", "min", "max", "_sign", "_step", "_sin", "_cos"}),
    define="{} = {}".format,
    store="{} = {}".format,
    comment="# {}".format,
    entry=lambda vector, i: f"{vector}[{i}]" if vector == PARAMETERS else f"{vector}[{i} * S + k]",
)


def body_lines(program: Program, indent: str = "    ") -> list[str]:
    """Lines that load the inputs that are used, compute, and store the outputs.

    Entry i of a vector is at ``i * S + k``: that of state k among S, or with S = 1, k = 0 of a single one.
    """
    return printer.body_lines(program, NUMBA, "out[{} * S + k]".format, indent)
