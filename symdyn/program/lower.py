"""From SymPy to a program: named steps and outputs become lines, in time linear in their size."""

from __future__ import annotations

import math
from collections.abc import Sequence

import sympy

from symdyn.base import nonsmooth
from symdyn.derive.steps import Step
from symdyn.program.builder import Builder
from symdyn.program.errors import ProgramError
from symdyn.program.order import StructuralOrder
from symdyn.program.ssa import Argument, Op, Program

_FUNCTIONS = {
    sympy.sin: Op.SIN,
    sympy.cos: Op.COS,
    sympy.tan: Op.TAN,
    sympy.tanh: Op.TANH,
    sympy.exp: Op.EXP,
    sympy.log: Op.LOG,
    sympy.Abs: Op.ABS,
    sympy.sign: Op.SIGN,
    sympy.Min: Op.MIN,
    sympy.Max: Op.MAX,
    sympy.floor: Op.FLOOR,
    sympy.atan2: Op.ATAN2,
    nonsmooth.sign_of: Op.SIGN,
    nonsmooth.step: Op.STEP,
}

_Signed = tuple[bool, int]  # (negative, line): the sign stays off the line until something needs it


def lower(
    name: str,
    arguments: Sequence[Argument],
    steps: Sequence[Step],
    outputs: Sequence[sympy.Expr],
    shape: tuple[int, ...],
) -> Program:
    """The program of ``outputs`` (flat, row-major of ``shape``), which may use arguments and earlier steps.

    Rational numbers become the nearest double, integer powers products, negative powers divisions; any
    other power needs a base that SymPy knows to be positive.
    Raises ProgramError: SD811 for a symbol that is neither argument nor earlier step, or defined
    twice; SD812 for an expression with no meaning in a program; SD815 for an infinite number.
    """
    work = _Lowering(arguments)
    for step in steps:
        work.step(step)
    lines = [work.expression(output, "") for output in outputs]
    return work.builder.program(name, tuple(arguments), lines, shape)


class _Lowering:
    def __init__(self, arguments: Sequence[Argument]) -> None:
        self.builder = Builder()
        self._order = StructuralOrder()
        self._symbols: dict[str, _Signed] = {}
        self._done: dict[int, _Signed] = {}
        self._alive: list[sympy.Basic] = []  # results are stored by id
        self._origin = ""
        for argument in arguments:
            for symbol in argument.symbols:
                self._define(symbol, (False, self.builder.input(symbol)))

    def step(self, step: Step) -> None:
        line = self.expression(step.expression, step.origin)
        if self.builder.ops[line] is not Op.INPUT:
            self.builder.label(line, step.symbol.name)
        self._define(step.symbol.name, (False, line))

    def expression(self, expression: sympy.Expr, origin: str) -> int:
        """The line of one expression; an explicit stack, so that depth has no limit."""
        self._origin = origin
        root = sympy.sympify(expression, strict=True)
        stack = [root]
        while stack:
            top = stack[-1]
            if id(top) in self._done:
                stack.pop()
                continue
            operands = self._operands(top)
            waiting = [operand for operand in operands if id(operand) not in self._done]
            if waiting:
                stack.extend(reversed(waiting))
            else:
                self._done[id(top)] = self._line(top, [self._done[id(operand)] for operand in operands])
                self._alive.append(top)
        return self._plain(self._done[id(root)])

    def _define(self, name: str, value: _Signed) -> None:
        if name in self._symbols:
            raise ProgramError("SD811", f"the symbol {name} is defined twice")
        self._symbols[name] = value

    def _operands(self, expression: sympy.Basic) -> tuple[sympy.Basic, ...]:
        """What must be lowered first; the exponent of an ordinary power is read from the expression itself."""
        if expression.is_Pow:
            return (expression.base,) if (2 * expression.exp).is_Integer else expression.args
        return self._order.operands(expression)

    def _line(self, expression: sympy.Basic, operands: list[_Signed]) -> _Signed:
        if expression.is_Symbol:
            return self._symbol(expression.name)
        if expression.is_Number or expression.is_NumberSymbol:
            return self._number(expression)
        if expression.is_Add:
            return self._sum(operands)
        if expression.is_Mul:
            factors = self._order.operands(expression)
            return self._product(list(zip(factors, operands, strict=True)))
        if expression.is_Pow:
            return (
                self._power(expression, operands[0]) if len(operands) == 1 else self._exponential(expression, operands)
            )
        if isinstance(expression, nonsmooth.pushing):
            return False, self._pushing(*(self._plain(operand) for operand in operands))
        if isinstance(expression, (nonsmooth.deadzone, nonsmooth.outside)):
            return self._gap(expression, operands)
        if isinstance(expression, nonsmooth.clip):
            return self._clip(operands)
        if isinstance(expression, nonsmooth.quantise):
            return self._quantum(operands)
        return self._call(expression, operands)

    def _symbol(self, name: str) -> _Signed:
        if name not in self._symbols:
            known = ", ".join(sorted(self._symbols)[:12])
            hint = "a symbol must be an argument, or the symbol of an earlier step"
            raise ProgramError("SD811", f"unknown symbol {name} (known: {known}, ...)", hint)
        return self._symbols[name]

    def _number(self, number: sympy.Expr) -> _Signed:
        value = _float(number)
        return value < 0, self.builder.constant(abs(value))

    def _sum(self, terms: list[_Signed]) -> _Signed:
        """Positive terms first, so that signs become subtractions."""
        ordered = sorted(terms, key=lambda term: term[0])
        all_negative, total = ordered[0]
        for negative, line in ordered[1:]:
            total = self._make(Op.SUB if negative and not all_negative else Op.ADD, total, line)
        return all_negative, total

    def _product(self, factors: list[tuple[sympy.Basic, _Signed]]) -> _Signed:
        """Factors with a negative power were lowered as reciprocals; they share one division."""
        negative = False
        above: list[int] = []
        below: list[int] = []
        for factor, (sign, line) in factors:
            negative ^= sign
            if factor.is_Pow and factor.exp.is_negative and (2 * factor.exp).is_Integer:
                below.append(self.builder.args[line][1])
            elif self.builder.values[line] != 1.0:
                above.append(line)
        numerator = self._chain(Op.MUL, above) if above else self.builder.constant(1.0)
        return negative, self._make(Op.DIV, numerator, self._chain(Op.MUL, below)) if below else numerator

    def _power(self, power: sympy.Pow, base: _Signed) -> _Signed:
        exponent = power.exp
        count = abs(int(2 * exponent)) // 2
        negative, line = base[0] and exponent.is_Integer and count % 2 == 1, base[1]
        parts = [self._repeated(line, count)] if count else []
        if not exponent.is_Integer:
            parts.append(self._make(Op.SQRT, self._plain(base)))
            if base[0] and count:  # an integer part of the power needs the sign as well
                parts[0] = self._repeated(self._plain(base), count)
        result = self._chain(Op.MUL, parts)
        if exponent.is_negative:
            result = self._make(Op.DIV, self.builder.constant(1.0), result)
        return negative, result

    def _exponential(self, power: sympy.Pow, operands: list[_Signed]) -> _Signed:
        """Any exponent, where the base is known to be positive: exp(exponent * log(base))."""
        if not power.base.is_positive:
            raise ProgramError("SD812", f"{power}: the exponent is no integer or half, and the base may be negative")
        logarithm = self._make(Op.LOG, self._plain(operands[0]))
        negative, exponent = operands[1]
        product = self._make(Op.MUL, exponent, logarithm)
        return False, self._make(Op.EXP, self._plain((negative, product)))

    def _repeated(self, line: int, count: int) -> int:
        """``line ** count`` by repeated squaring."""
        square, parts = line, list[int]()
        while count:
            if count & 1:
                parts.append(square)
            count >>= 1
            if count:
                square = self._make(Op.MUL, square, square)
        return self._chain(Op.MUL, parts)

    def _gap(self, expression: sympy.Basic, operands: list[_Signed]) -> _Signed:
        """outside(x, s) = step(abs(x) - s); deadzone(x, s) = outside(x, s) * (x - s sign(x))."""
        (negative, x), s = operands[0], self._plain(operands[1])
        outside = self._make(Op.STEP, self._make(Op.SUB, self._make(Op.ABS, x), s))
        if isinstance(expression, nonsmooth.outside):
            return False, outside
        shift = self._make(Op.MUL, s, self._make(Op.SIGN, x))
        return negative, self._make(Op.MUL, outside, self._make(Op.SUB, x, shift))

    def _clip(self, operands: list[_Signed]) -> _Signed:
        """max(low, min(x, high))."""
        x, low, high = (self._plain(operand) for operand in operands)
        return False, self._make(Op.MAX, self._make(Op.MIN, x, high), low)

    def _quantum(self, operands: list[_Signed]) -> _Signed:
        """q floor(x / q + 1/2)."""
        x, q = (self._plain(operand) for operand in operands)
        count = self._make(Op.ADD, self._make(Op.DIV, x, q), self.builder.constant(0.5))
        return False, self._make(Op.MUL, q, self._make(Op.FLOOR, count))

    def _pushing(self, force: int, x: int, s: int) -> int:
        """1 - step(s) step(force x)."""
        pulls = self._make(Op.MUL, self._make(Op.STEP, s), self._make(Op.STEP, self._make(Op.MUL, force, x)))
        return self._make(Op.SUB, self.builder.constant(1.0), pulls)

    def _call(self, expression: sympy.Basic, operands: list[_Signed]) -> _Signed:
        op = _FUNCTIONS.get(type(expression))
        if isinstance(expression, sympy.atan):  # SymPy makes it of an atan2 whose x is known to be positive
            return False, self._make(Op.ATAN2, self._plain(operands[0]), self.builder.constant(1.0))
        if op is None:
            kind = type(expression).__name__
            known = ", ".join(sorted(function.__name__ for function in _FUNCTIONS))
            message = f"{kind} has no meaning in a program: {expression}"
            raise ProgramError("SD812", message, f"known functions: {known}")
        lines = [self._plain(operand) for operand in operands]
        return False, self._chain(op, lines) if op in (Op.MIN, Op.MAX) else self._make(op, *lines)

    def _chain(self, op: Op, lines: list[int]) -> int:
        result = lines[0]
        for line in lines[1:]:
            result = self._make(op, result, line)
        return result

    def _plain(self, signed: _Signed) -> int:
        """The line with its sign applied."""
        negative, line = signed
        if not negative:
            return line
        value = self.builder.values[line]
        return self.builder.constant(-value) if value is not None else self._make(Op.NEG, line)

    def _make(self, op: Op, *args: int) -> int:
        return self.builder.intern(op, args, self._origin)


def _float(number: sympy.Expr) -> float:
    """The nearest double; a rational is divided once, exactly rounded."""
    try:
        if number.is_Rational:
            value = int(number.p) / int(number.q)
        elif number.is_Float:
            value = float(number)
        elif number is sympy.pi:
            value = math.pi
        elif number is sympy.E:
            value = math.e
        else:
            value = math.nan
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        raise ProgramError("SD815", f"{number} is not a finite number that a program can hold")
    return value
