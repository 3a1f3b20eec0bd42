"""Numba's syntax: what the functions of a kernel are made of."""

from __future__ import annotations

from collections.abc import Callable

from symdyn.emit import printer
from symdyn.emit.printer import Syntax
from symdyn.program.ssa import Op, Program

NUMBA = Syntax(
    calls={
        Op.SIN: "math.sin",
        Op.COS: "math.cos",
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
    },
    reserved=frozenset({"out", "math", "np", "k", "abs", "min", "max", "_sign", "_step"}),
    define="{} = {}".format,
    store="{} = {}".format,
    comment="# {}".format,
)


def body_lines(program: Program, store: Callable[[int], str], indent: str = "    ") -> list[str]:
    """Lines that load the inputs that are used, compute, and store output k at ``store(k)``."""
    return printer.body_lines(program, NUMBA, store, indent)
