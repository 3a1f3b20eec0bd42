"""Programs evaluated in double precision, with derivatives along given directions carried beside every line."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from symdyn.program.ssa import Op, Program

Array = NDArray[np.float64]

_VALUE: dict[Op, Callable[..., Array]] = {
    Op.ADD: np.add,
    Op.SUB: np.subtract,
    Op.MUL: np.multiply,
    Op.DIV: np.divide,
    Op.NEG: np.negative,
    Op.SIN: np.sin,
    Op.COS: np.cos,
    Op.TAN: np.tan,
    Op.TANH: np.tanh,
    Op.EXP: np.exp,
    Op.LOG: np.log,
    Op.SQRT: np.sqrt,
    Op.ABS: np.abs,
    Op.SIGN: np.sign,
    Op.MIN: np.minimum,
    Op.MAX: np.maximum,
    Op.ATAN2: np.arctan2,
    Op.FLOOR: np.floor,
    Op.STEP: lambda a: np.greater(a, 0.0).astype(np.float64),
}


def evaluate_arrays(
    program: Program, inputs: Mapping[str, Array], directions: Mapping[str, Array] | None = None
) -> tuple[Array, Array]:
    """Outputs of shape ``program.shape``, and their derivatives (k, *shape) along k directions.

    ``inputs`` has a vector per argument, ``directions`` for some of them an array (k, length): row j is how that
    argument moves along direction j. Forward mode, exact to rounding; at kinks as ``differentiate``. Division by
    zero and the like give infinities and NaN, without a warning.
    """
    moved = directions or {}
    count = next((len(rows) for rows in moved.values()), 0)
    symbols: dict[str, float] = {}
    seeds: dict[str, Array] = {}
    for argument in program.arguments:
        symbols |= dict(zip(argument.symbols, map(float, inputs[argument.name]), strict=True))
        if argument.name in moved:
            seeds |= dict(zip(argument.symbols, np.asarray(moved[argument.name], np.float64).T, strict=True))
    values: list[Array] = []
    tangents: list[Array | None] = []  # None: zero by structure
    with np.errstate(all="ignore"):
        for node in program.nodes:
            if node.op is Op.CONST:
                assert node.value is not None
                values.append(np.float64(node.value))  # type: ignore[arg-type]  # a scalar does as an array does
                tangents.append(None)
            elif node.op is Op.INPUT:
                assert node.name is not None
                values.append(np.float64(symbols[node.name]))  # type: ignore[arg-type]
                seed = seeds.get(node.name)
                tangents.append(seed if seed is not None and seed.any() else None)
            else:
                args = tuple(values[i] for i in node.args)
                value = _VALUE[node.op](*args)
                values.append(value)
                tangents.append(_tangent(node.op, args, value, [tangents[i] for i in node.args]))
    outputs = np.array([values[i] for i in program.outputs], np.float64).reshape(program.shape)
    columns = [tangents[i] for i in program.outputs]
    zero = np.zeros(count)
    derivative = np.array([zero if column is None else column for column in columns]).reshape(len(columns), count)
    return outputs, derivative.T.reshape(count, *program.shape)


def _tangent(op: Op, args: tuple[Array, ...], value: Array, inner: list[Array | None]) -> Array | None:
    """Sum over arguments of partial derivative times tangent."""
    total: Array | None = None
    for which, tangent in enumerate(inner):
        if tangent is None:
            continue
        scale = _partial(op, args, value, which)
        if scale is None:
            continue
        term = scale * tangent
        total = term if total is None else total + term
    return total


def _partial(op: Op, args: tuple[Array, ...], value: Array, which: int) -> Array | float | None:
    """d value / d args[which]; None where it is zero everywhere."""
    x = args[which]
    match op:
        case Op.ADD:
            return 1.0
        case Op.SUB:
            return 1.0 if which == 0 else -1.0
        case Op.NEG:
            return -1.0
        case Op.MUL:
            return args[1 - which]
        case Op.DIV:
            return 1.0 / args[1] if which == 0 else -value / args[1]
        case Op.SIN:
            return np.cos(x)
        case Op.COS:
            return -np.sin(x)
        case Op.TAN:
            return 1.0 + value * value
        case Op.TANH:
            return 1.0 - value * value
        case Op.EXP:
            return value
        case Op.LOG:
            return 1.0 / x
        case Op.SQRT:
            return 0.5 / value
        case Op.ABS:
            return np.sign(x)
        case Op.MIN | Op.MAX:  # at equality the second argument, as ``differentiate`` has it
            smaller, larger = args if op is Op.MIN else args[::-1]
            first = float(larger > smaller)
            return first if which == 0 else 1.0 - first
        case Op.ATAN2:
            square = args[0] ** 2 + args[1] ** 2
            return args[1] / square if which == 0 else -args[0] / square
        case _:  # SIGN, STEP, FLOOR
            return None
