"""Local algebra: the simplest line for one operation, given what its arguments are.

Every rule replaces one operation by at most one operation, so folding never adds work. Rules hold
for finite reals wherever the original is defined; signed zeros, infinities and NaN are not kept.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from symdyn.program.builder import Builder
from symdyn.program.ssa import Op

_NUMBERS: dict[Op, Callable[..., float]] = {
    Op.ADD: lambda a, b: a + b,
    Op.SUB: lambda a, b: a - b,
    Op.MUL: lambda a, b: a * b,
    Op.DIV: lambda a, b: a / b,
    Op.NEG: lambda a: -a,
    Op.SIN: math.sin,
    Op.COS: math.cos,
    Op.TAN: math.tan,
    Op.TANH: math.tanh,
    Op.EXP: math.exp,
    Op.LOG: math.log,
    Op.SQRT: math.sqrt,
    Op.ABS: abs,
    Op.SIGN: lambda a: float((a > 0) - (a < 0)),
    Op.MIN: min,
    Op.MAX: max,
    Op.ATAN2: math.atan2,
    Op.STEP: lambda a: float(a > 0),
    Op.FLOOR: lambda a: float(math.floor(a)),
}


def fold(builder: Builder, op: Op, args: tuple[int, ...], origin: str = "") -> int:
    """The line of ``op(args)`` after every local rule that applies."""
    ops, triggers = builder.ops, TRIGGERS[op]
    if ops[args[0]] not in triggers and ops[args[-1]] not in triggers and (len(args) == 1 or args[0] != args[1]):
        return builder.intern(op, args, origin)  # most lines: no rule can apply
    line = _number(builder, op, args)
    if line is not None:
        return line
    rule = _RULES.get(op)
    line = rule(builder, args, origin) if rule else None
    return builder.intern(op, args, origin) if line is None else line


def _number(b: Builder, op: Op, args: tuple[int, ...]) -> int | None:
    """The constant that an operation on constants gives; None where it is not finite."""
    values = []
    for argument in args:
        value = b.values[argument]
        if value is None:
            return None
        values.append(value)
    try:
        result = _NUMBERS[op](*values)
    except (ArithmeticError, ValueError):
        return None
    return b.constant(result) if math.isfinite(result) else None


def _inside(b: Builder, line: int, op: Op) -> tuple[int, ...]:
    """The arguments of the line if its operation is ``op``, else ()."""
    return b.args[line] if b.ops[line] is op else ()


def _scaled(b: Builder, line: int) -> tuple[float, int] | None:
    """(c, x) if the line is the product of a number and x."""
    if b.ops[line] is Op.MUL:
        first, second = b.args[line]
        for number, other in ((first, second), (second, first)):
            value = b.values[number]
            if value is not None:
                return value, other
    return None


def _times(b: Builder, coefficient: float, line: int, origin: str) -> int | None:
    """A number times a line that is no number; None if the number overflowed."""
    if not math.isfinite(coefficient):
        return None
    if coefficient == 0.0:
        return b.constant(0.0)
    if coefficient == 1.0:
        return line
    if coefficient == -1.0:
        return _negative(b, (line,), origin) or b.intern(Op.NEG, (line,), origin)
    return b.intern(Op.MUL, (b.constant(coefficient), line), origin)


def _add(b: Builder, args: tuple[int, ...], origin: str) -> int | None:
    for x, y in (args, args[::-1]):
        if b.values[x] == 0.0:
            return y
        if negated := _inside(b, x, Op.NEG):
            return fold(b, Op.SUB, (y, negated[0]), origin)
        if (difference := _inside(b, x, Op.SUB)) and difference[1] == y:
            return difference[0]
        number = b.values[x]
        inner = _inside(b, y, Op.ADD)
        if number is not None and inner:
            for constant, other in (inner, inner[::-1]):
                value = b.values[constant]
                if value is not None and math.isfinite(number + value):
                    return fold(b, Op.ADD, (b.constant(number + value), other), origin)
    return None


def _subtract(b: Builder, args: tuple[int, ...], origin: str) -> int | None:
    x, y = args
    if x == y:
        return b.constant(0.0)
    if b.values[y] == 0.0:
        return x
    if b.values[x] == 0.0:
        return fold(b, Op.NEG, (y,), origin)
    if negated := _inside(b, y, Op.NEG):
        return fold(b, Op.ADD, (x, negated[0]), origin)
    if y in (total := _inside(b, x, Op.ADD)):
        return total[0] if total[1] == y else total[1]
    if (difference := _inside(b, y, Op.SUB)) and difference[0] == x:
        return difference[1]
    return None


def _multiply(b: Builder, args: tuple[int, ...], origin: str) -> int | None:
    for x, y in (args, args[::-1]):
        number = b.values[x]
        if number is not None:
            scaled = _scaled(b, y)
            if scaled is not None:
                return _times(b, number * scaled[0], scaled[1], origin)
            if negated := _inside(b, y, Op.NEG):
                return _times(b, -number, negated[0], origin)
            return _times(b, number, y, origin) if number in (0.0, 1.0, -1.0) else None
    left, right = _inside(b, args[0], Op.NEG), _inside(b, args[1], Op.NEG)
    if left and right:
        return fold(b, Op.MUL, (left[0], right[0]), origin)
    return None


def _divide(b: Builder, args: tuple[int, ...], origin: str) -> int | None:
    x, y = args
    number = b.values[y]
    if b.values[x] == 0.0 and number != 0.0:
        return b.constant(0.0)
    if x == y:
        return b.constant(1.0)
    if number in (1.0, -1.0):
        return x if number == 1.0 else fold(b, Op.NEG, (x,), origin)
    left, right = _inside(b, x, Op.NEG), _inside(b, y, Op.NEG)
    if left and right:
        return fold(b, Op.DIV, (left[0], right[0]), origin)
    if y in (product := _inside(b, x, Op.MUL)):
        return product[0] if product[1] == y else product[1]
    return None


def _negative(b: Builder, args: tuple[int, ...], origin: str) -> int | None:
    (x,) = args
    if negated := _inside(b, x, Op.NEG):
        return negated[0]
    if difference := _inside(b, x, Op.SUB):
        return fold(b, Op.SUB, difference[::-1], origin)
    scaled = _scaled(b, x)
    return _times(b, -scaled[0], scaled[1], origin) if scaled is not None else None


def _even(op: Op) -> Callable[[Builder, tuple[int, ...], str], int | None]:
    def rule(b: Builder, args: tuple[int, ...], origin: str) -> int | None:
        negated = _inside(b, args[0], Op.NEG)
        return fold(b, op, negated, origin) if negated else None

    return rule


def _absolute(b: Builder, args: tuple[int, ...], origin: str) -> int | None:
    if negated := _inside(b, args[0], Op.NEG):
        return fold(b, Op.ABS, negated, origin)
    return args[0] if b.ops[args[0]] in (Op.ABS, Op.SQRT, Op.EXP, Op.STEP) else None


def _root(b: Builder, args: tuple[int, ...], origin: str) -> int | None:
    square = _inside(b, args[0], Op.MUL)
    return fold(b, Op.ABS, (square[0],), origin) if square and square[0] == square[1] else None


def _idempotent(b: Builder, args: tuple[int, ...], origin: str) -> int | None:
    return args[0] if args[0] == args[1] else None


def _projection(op: Op) -> Callable[[Builder, tuple[int, ...], str], int | None]:
    def rule(b: Builder, args: tuple[int, ...], origin: str) -> int | None:
        return args[0] if b.ops[args[0]] is op else None

    return rule


_RULES: dict[Op, Callable[[Builder, tuple[int, ...], str], int | None]] = {
    Op.ADD: _add,
    Op.SUB: _subtract,
    Op.MUL: _multiply,
    Op.DIV: _divide,
    Op.NEG: _negative,
    Op.COS: _even(Op.COS),
    Op.ABS: _absolute,
    Op.SQRT: _root,
    Op.SIGN: _projection(Op.SIGN),
    Op.STEP: _projection(Op.STEP),
    Op.FLOOR: _projection(Op.FLOOR),
    Op.MIN: _idempotent,
    Op.MAX: _idempotent,
}

# A rule applies only where an argument is a number or one of these, or where both arguments are the same line.
TRIGGERS: dict[Op, frozenset[Op]] = dict.fromkeys(Op, frozenset({Op.CONST})) | {
    Op.ADD: frozenset({Op.CONST, Op.NEG, Op.SUB}),
    Op.SUB: frozenset({Op.CONST, Op.NEG, Op.ADD, Op.SUB}),
    Op.MUL: frozenset({Op.CONST, Op.NEG}),
    Op.DIV: frozenset({Op.CONST, Op.NEG, Op.MUL}),
    Op.NEG: frozenset({Op.CONST, Op.NEG, Op.SUB, Op.MUL}),
    Op.COS: frozenset({Op.CONST, Op.NEG}),
    Op.ABS: frozenset({Op.CONST, Op.NEG, Op.ABS, Op.SQRT, Op.EXP, Op.STEP}),
    Op.SQRT: frozenset({Op.CONST, Op.MUL}),
    Op.SIGN: frozenset({Op.CONST, Op.SIGN}),
    Op.FLOOR: frozenset({Op.CONST, Op.FLOOR}),
    Op.STEP: frozenset({Op.CONST, Op.STEP}),
}
