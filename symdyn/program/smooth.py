"""Jumps replaced by slopes of a stated width: for solvers that cannot locate events."""

from __future__ import annotations

from symdyn.program.builder import Builder
from symdyn.program.ssa import Op, Program

ORIGIN = "smoothed jump"


def smooth(program: Program, width: float) -> Program:
    """sign(x) becomes tanh(x / width), step(x) becomes (1 + tanh(x / width)) / 2.

    ``width`` is in the SI unit of x (rad/s for friction, rad for contact). Smoothing costs accuracy
    that no solver tolerance buys back: an error of the order of the width stays.
    """
    if not width > 0:
        raise ValueError("the width of a smoothed jump must be positive")
    builder, lines = Builder(), list[int]()
    slope, half, one = builder.constant(1.0 / width), builder.constant(0.5), builder.constant(1.0)
    for node in program.nodes:
        args = tuple(lines[i] for i in node.args)
        if node.op in (Op.SIGN, Op.STEP):
            line = builder.intern(Op.TANH, (builder.intern(Op.MUL, (args[0], slope), ORIGIN),), ORIGIN)
            if node.op is Op.STEP:
                line = builder.intern(Op.MUL, (half, builder.intern(Op.ADD, (one, line), ORIGIN)), ORIGIN)
        else:
            line = builder.copy(node, args)
        lines.append(line)
    return builder.program(program.name, program.arguments, [lines[i] for i in program.outputs], program.shape)
