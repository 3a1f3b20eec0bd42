"""Jacobians by forward mode over the program; entries that are zero by structure cost nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from symdyn.program.builder import Builder
from symdyn.program.errors import ProgramError
from symdyn.program.folding import fold
from symdyn.program.ssa import NULLARY, Op, Program

_Tangent = dict[int, int]  # number of the variable -> line of the derivative; absent where it is zero


def differentiate(program: Program, wrt: Sequence[str], name: str) -> Program:
    """The Jacobian of all outputs, of shape ``program.shape + (len(wrt),)``, as a function of the same arguments.

    At a kink the derivative is one-sided or 0: that of ABS is SIGN, of SIGN and STEP 0, and MIN and
    MAX at equality follow their second argument. Raises ProgramError (SD814) for a name that is no input.
    """
    unknown = sorted(set(wrt) - set(program.symbols))
    if unknown:
        raise ProgramError("SD814", f"program {program.name!r} has no input {', '.join(unknown)}")
    position = {symbol: index for index, symbol in enumerate(wrt)}
    if len(position) != len(wrt):
        raise ProgramError("SD814", f"program {program.name!r}: a variable of differentiation is repeated")

    b = Builder()
    lines: list[int] = []
    tangents: list[_Tangent] = []
    for node in program.nodes:
        args = tuple(lines[argument] for argument in node.args)
        line = b.copy(node, args)
        lines.append(line)
        if node.op in NULLARY:
            tangents.append({position[node.name]: b.constant(1.0)} if node.name in position else {})
        else:
            inner = [tangents[argument] for argument in node.args]
            tangents.append(_chain(b, node.op, args, line, inner, f"derivative: {node.origin}".rstrip(": ")))
    zero = b.constant(0.0)
    outputs = [tangents[output].get(index, zero) for output in program.outputs for index in range(len(wrt))]
    return b.program(name, program.arguments, outputs, (*program.shape, len(wrt)))


def _chain(b: Builder, op: Op, args: tuple[int, ...], line: int, inner: list[_Tangent], origin: str) -> _Tangent:
    """Derivatives of ``line = op(args)``: the sum over arguments of partial times tangent."""
    result: _Tangent = {}
    zero = b.constant(0.0)
    for which, tangent in enumerate(inner):
        if not tangent:
            continue
        scale = _partial(b, op, args, line, which, origin)
        for variable, derivative in tangent.items():
            term = scale(derivative)
            if variable in result:
                term = fold(b, Op.ADD, (result[variable], term), origin)
            result[variable] = term
    return {variable: derivative for variable, derivative in result.items() if derivative != zero}


def _partial(b: Builder, op: Op, args: tuple[int, ...], line: int, which: int, origin: str) -> Callable[[int], int]:
    """The map from a tangent of argument ``which`` to its share in the tangent of ``line``."""

    def make(op: Op, *operands: int) -> int:
        return fold(b, op, operands, origin)

    one = b.constant(1.0)
    x = args[which]
    other = args[1 - which] if len(args) == 2 else x
    match op:
        case Op.ADD:
            return lambda d: d
        case Op.SUB:
            return (lambda d: d) if which == 0 else (lambda d: make(Op.NEG, d))
        case Op.NEG:
            return lambda d: make(Op.NEG, d)
        case Op.DIV if which == 0:
            return lambda d: make(Op.DIV, d, other)
        case Op.LOG:
            return lambda d: make(Op.DIV, d, x)
        case Op.COS:
            sine = make(Op.SIN, x)
            return lambda d: make(Op.NEG, make(Op.MUL, sine, d))
        case Op.MUL:
            factor = other
        case Op.DIV:  # d(a/b)/db = -(a/b)/b
            factor = make(Op.NEG, make(Op.DIV, line, x))
        case Op.SIN:
            factor = make(Op.COS, x)
        case Op.TAN:
            factor = make(Op.ADD, one, make(Op.MUL, line, line))
        case Op.TANH:
            factor = make(Op.SUB, one, make(Op.MUL, line, line))
        case Op.EXP:
            factor = line
        case Op.SQRT:
            factor = make(Op.DIV, b.constant(0.5), line)
        case Op.ABS:
            factor = make(Op.SIGN, x)
        case Op.MIN | Op.MAX:
            factor = _selected(b, op, args, which, origin)
        case Op.ATAN2:  # atan2(y, x): (x dy - y dx) / (x^2 + y^2)
            square = make(Op.ADD, make(Op.MUL, x, x), make(Op.MUL, other, other))
            factor = make(Op.DIV, other, square)
            factor = factor if which == 0 else make(Op.NEG, factor)
        case _:  # SIGN, STEP, FLOOR: constant between their jumps
            zero = b.constant(0.0)
            return lambda d: zero
    return lambda d: make(Op.MUL, factor, d)


def _selected(b: Builder, op: Op, args: tuple[int, ...], which: int, origin: str) -> int:
    """1 where MIN or MAX takes its argument ``which``, else 0; the two always add up to 1."""
    smaller, larger = args if op is Op.MIN else args[::-1]
    first = fold(b, Op.STEP, (fold(b, Op.SUB, (larger, smaller), origin),), origin)
    return first if which == 0 else fold(b, Op.SUB, (b.constant(1.0), first), origin)
