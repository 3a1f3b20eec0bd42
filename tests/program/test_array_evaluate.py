"""Double precision with directions: the reference evaluator's values, and the derivatives of ``differentiate``."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from symdyn.program.array_evaluate import _VALUE, evaluate_arrays
from symdyn.program.builder import Builder
from symdyn.program.differentiate import differentiate
from symdyn.program.evaluate import evaluate
from symdyn.program.ssa import NULLARY, Argument, Op, Program

from .strategies import POINTS, SYMBOLS, programs

EVERY = {"x": np.eye(3)[:, :2], "p": np.eye(3)[:, 2:]}


@pytest.mark.parametrize("point", POINTS)
@given(program=programs(size=20))
def test_values_and_derivatives(point: dict[str, tuple[float, ...]], program: Program) -> None:
    inputs = {name: np.array(values) for name, values in point.items()}
    values, along = evaluate_arrays(program, inputs, EVERY)
    assert values.shape == program.shape
    assert along.shape == (3, *program.shape)
    exact = np.array([float(v) for v in evaluate(program, point)])
    jacobian = np.array([float(v) for v in evaluate(differentiate(program, SYMBOLS, "J"), point)]).reshape(-1, 3)
    # rounding is relative to the largest line, not to what is left of it after a subtraction
    lines = evaluate(Program("all", program.arguments, program.nodes, tuple(range(len(program.nodes))),
                             (len(program.nodes),)), point)  # fmt: skip
    size = max(float(max(abs(v) for v in lines)), 1.0)
    if size < 1e4:
        assert values == pytest.approx(exact, rel=1e-9, abs=1e-9 * size)
        assert pytest.approx(jacobian, rel=1e-7, abs=1e-7 * max(size, float(np.abs(jacobian).max()))) == along.T


@pytest.mark.parametrize(
    ("op", "at", "slope"),
    [
        (Op.SIN, 0.4, np.cos(0.4)), (Op.COS, 0.4, -np.sin(0.4)), (Op.TAN, 0.4, 1 / np.cos(0.4) ** 2),
        (Op.TANH, 0.4, 1 / np.cosh(0.4) ** 2), (Op.EXP, 0.4, np.exp(0.4)), (Op.LOG, 0.4, 2.5),
        (Op.SQRT, 0.25, 1.0), (Op.ABS, -0.4, -1.0), (Op.SIGN, 0.4, 0.0), (Op.STEP, 0.4, 0.0),
        (Op.FLOOR, 1.4, 0.0), (Op.NEG, 0.4, -1.0),
    ],
)  # fmt: skip
def test_each_operation_of_one_argument(op: Op, at: float, slope: float) -> None:
    builder = Builder()
    line = builder.intern(op, (builder.input("x"),))
    program = builder.program("f", (Argument("x", ("x",)),), (line,), (1,))
    _, along = evaluate_arrays(program, {"x": np.array([at])}, {"x": np.array([[1.0], [-3.0]])})
    assert along == pytest.approx(np.array([[slope], [-3 * slope]]), rel=1e-12)


@pytest.mark.parametrize("op", [Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.MIN, Op.MAX, Op.ATAN2])
@pytest.mark.parametrize("at", [(0.7, -1.3), (-1.3, 0.7), (0.7, 0.7)])
def test_each_operation_of_two_arguments(op: Op, at: tuple[float, float]) -> None:
    builder = Builder()
    line = builder.intern(op, (builder.input("x"), builder.input("y")))
    program = builder.program("f", (Argument("v", ("x", "y")),), (line,), (1,))
    values, along = evaluate_arrays(program, {"v": np.array(at)}, {"v": np.eye(2)})
    assert values == pytest.approx([float(v) for v in evaluate(program, {"v": at})])
    slopes = evaluate(differentiate(program, ("x", "y"), "J"), {"v": at})
    assert along[:, 0] == pytest.approx([float(v) for v in slopes])


def test_every_operation_has_a_value() -> None:
    assert set(_VALUE) == set(Op) - NULLARY


def test_division_by_zero_is_quiet() -> None:
    builder = Builder()
    line = builder.intern(Op.DIV, (builder.constant(1.0), builder.input("x")))
    program = builder.program("f", (Argument("x", ("x",)),), (line,), (1,))
    values, along = evaluate_arrays(program, {"x": np.zeros(1)}, {"x": np.ones((1, 1))})
    assert np.isinf(values[0])
    assert not np.isfinite(along[0, 0])
