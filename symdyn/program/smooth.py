"""Jumps replaced by slopes of a stated width: for solvers that cannot locate events."""

from __future__ import annotations

import math
from collections.abc import Mapping

from symdyn.program.builder import Builder
from symdyn.program.ssa import Op, Program

ORIGIN = "smoothed jump"


def smooth(program: Program, width: float | Mapping[str, float]) -> Program:
    """sign(x) becomes tanh(x / width), step(x) becomes (1 + tanh(x / width)) / 2.

    ``width`` is in the SI unit of x (rad/s for friction, rad for contact). Smoothing costs accuracy
    that no solver tolerance buys back: an error of the order of the width stays. With a width for each of some speeds
    only signs of what depends on one of them: friction, but neither contacts nor limits. The narrowest counts.
    """
    friction_only = isinstance(width, Mapping)
    each, usual = (width, math.inf) if isinstance(width, Mapping) else ({}, width)
    if not all(w > 0 for w in (usual, *each.values())):
        raise ValueError("the width of a smoothed jump must be positive")
    builder, lines = Builder(), list[int]()
    half, one = builder.constant(0.5), builder.constant(1.0)
    widths = [usual] * len(program.nodes)
    for i, node in enumerate(program.nodes):
        if friction_only:
            own = each.get(node.name or "", math.inf) if node.op is Op.INPUT else math.inf
            widths[i] = min([own, *(widths[j] for j in node.args)])
        args = tuple(lines[i] for i in node.args)
        if widths[i] < math.inf and (node.op is Op.SIGN or (node.op is Op.STEP and not friction_only)):
            slope = builder.constant(1.0 / widths[i])
            line = builder.intern(Op.TANH, (builder.intern(Op.MUL, (args[0], slope), ORIGIN),), ORIGIN)
            if node.op is Op.STEP:
                line = builder.intern(Op.MUL, (half, builder.intern(Op.ADD, (one, line), ORIGIN)), ORIGIN)
        else:
            line = builder.copy(node, args)
        lines.append(line)
    return builder.program(program.name, program.arguments, [lines[i] for i in program.outputs], program.shape)
