"""Jumps replaced by slopes of a stated width: for solvers that cannot locate events."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.program.builder import Builder
from symdyn.program.ssa import Op, Program

ORIGIN = "smoothed jump"


def smooth(program: Program, width: float, friction_of: Sequence[str] | None = None) -> Program:
    """sign(x) becomes tanh(x / width), step(x) becomes (1 + tanh(x / width)) / 2.

    ``width`` is in the SI unit of x (rad/s for friction, rad for contact). Smoothing costs accuracy
    that no solver tolerance buys back: an error of the order of the width stays. With ``friction_of``, names of
    speeds, only signs of what depends on one of them: friction, but neither contacts nor limits.
    """
    if not width > 0:
        raise ValueError("the width of a smoothed jump must be positive")
    builder, lines = Builder(), list[int]()
    slope, half, one = builder.constant(1.0 / width), builder.constant(0.5), builder.constant(1.0)
    moving = [friction_of is None] * len(program.nodes)
    for i, node in enumerate(program.nodes):
        if friction_of is not None:
            moving[i] = any(moving[j] for j in node.args) or (node.op is Op.INPUT and node.name in friction_of)
        args = tuple(lines[i] for i in node.args)
        if moving[i] and (node.op is Op.SIGN or (node.op is Op.STEP and friction_of is None)):
            line = builder.intern(Op.TANH, (builder.intern(Op.MUL, (args[0], slope), ORIGIN),), ORIGIN)
            if node.op is Op.STEP:
                line = builder.intern(Op.MUL, (half, builder.intern(Op.ADD, (one, line), ORIGIN)), ORIGIN)
        else:
            line = builder.copy(node, args)
        lines.append(line)
    return builder.program(program.name, program.arguments, [lines[i] for i in program.outputs], program.shape)
