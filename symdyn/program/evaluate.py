"""The reference evaluator: slow, in arbitrary precision, and what every other back end must agree with."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mpmath
from mpmath import mpf

from symdyn.program.errors import ProgramError
from symdyn.program.ssa import Op, Program


def _divide(a: Any, b: Any) -> Any:
    if b != 0:
        return a / b
    return mpmath.nan if a == 0 or mpmath.isnan(a) else mpmath.sign(a) * mpmath.inf


def _log(a: Any) -> Any:
    return mpmath.log(a) if a > 0 else -mpmath.inf if a == 0 else mpmath.nan


_MEANING: dict[Op, Callable[..., Any]] = {
    Op.ADD: lambda a, b: a + b,
    Op.SUB: lambda a, b: a - b,
    Op.MUL: lambda a, b: a * b,
    Op.DIV: _divide,
    Op.NEG: lambda a: -a,
    Op.SIN: mpmath.sin,
    Op.COS: mpmath.cos,
    Op.TAN: mpmath.tan,
    Op.TANH: mpmath.tanh,
    Op.EXP: mpmath.exp,
    Op.LOG: _log,
    Op.SQRT: lambda a: mpmath.sqrt(a) if a >= 0 else mpmath.nan,
    Op.ABS: abs,
    Op.SIGN: lambda a: mpf(int(a > 0) - int(a < 0)),
    Op.MIN: min,
    Op.MAX: max,
    Op.ATAN2: mpmath.atan2,
    Op.STEP: lambda a: mpf(int(a > 0)),
    Op.FLOOR: mpmath.floor,
}


def evaluate(program: Program, inputs: Mapping[str, Sequence[float | mpf]], dps: int = 30) -> list[mpf]:
    """Outputs (row-major) at ``inputs``, one sequence per argument, with ``dps`` decimal digits.

    Division by zero gives an infinity or NaN, and the logarithm or root of a negative number NaN.
    Raises ProgramError (SD814) if an argument is missing, unknown or of the wrong length.
    """
    expected = {argument.name: len(argument.symbols) for argument in program.arguments}
    given = {name: len(values) for name, values in inputs.items()}
    if expected != given:
        raise ProgramError("SD814", f"program {program.name!r} takes arguments of lengths {expected}, not {given}")
    with mpmath.workdps(dps):
        symbols = {
            symbol: mpf(value)
            for argument in program.arguments
            for symbol, value in zip(argument.symbols, inputs[argument.name], strict=True)
        }
        values: list[mpf] = []
        for node in program.nodes:
            if node.op is Op.CONST:
                values.append(mpf(node.value))
            elif node.op is Op.INPUT:
                assert node.name is not None
                values.append(symbols[node.name])
            else:
                values.append(_MEANING[node.op](*(values[argument] for argument in node.args)))
        return [values[output] for output in program.outputs]
