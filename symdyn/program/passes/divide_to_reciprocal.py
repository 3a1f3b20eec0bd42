"""Divisions become multiplications where that is cheaper.

Several divisions by one line share its reciprocal, and a division by a number is a product with the
reciprocal number, which is exact for powers of two. Elsewhere the quotient is rounded twice: it may
differ from the division by about one unit in the last place, which is accepted.
"""

from __future__ import annotations

import math
from collections import Counter

from symdyn.program.builder import Builder
from symdyn.program.cost import cheaper
from symdyn.program.folding import fold
from symdyn.program.passes.rebuild import rebuild
from symdyn.program.ssa import Node, Op, Program


def divide_to_reciprocal(program: Program) -> Program:
    """Share reciprocals, and multiply by those of numbers."""
    divisors = Counter(node.args[1] for node in program.nodes if node.op is Op.DIV)
    shared = {divisor for divisor, times in divisors.items() if times > 1}
    if not shared and not any(program.nodes[divisor].op is Op.CONST for divisor in divisors):
        return program

    def make(builder: Builder, node: Node, args: tuple[int, ...]) -> int:
        if node.op is not Op.DIV:
            return builder.intern(node.op, args, node.origin)
        number = builder.values[args[1]]
        if number is not None:
            inverse = 1.0 / number if number != 0.0 else math.inf
            if not math.isfinite(inverse) or abs(inverse) < 2.0**-1022:  # a subnormal reciprocal loses digits
                return builder.intern(Op.DIV, args, node.origin)
            return fold(builder, Op.MUL, (args[0], builder.constant(inverse)), node.origin)
        if node.args[1] not in shared:
            return builder.intern(Op.DIV, args, node.origin)
        inverse_line = builder.intern(Op.DIV, (builder.constant(1.0), args[1]), node.origin)
        return fold(builder, Op.MUL, (args[0], inverse_line), node.origin)

    return cheaper(program, rebuild(program, make))
