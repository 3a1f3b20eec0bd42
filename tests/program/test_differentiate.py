"""Jacobians agree with SymPy and with finite differences of fifty digits, and zeros cost nothing."""

from __future__ import annotations

import mpmath
import pytest
import sympy
from hypothesis import given, settings

from symdyn.base.nonsmooth import deadzone
from symdyn.program.cost import Cost, count
from symdyn.program.differentiate import differentiate
from symdyn.program.errors import ProgramError
from symdyn.program.evaluate import evaluate
from symdyn.program.lower import lower
from symdyn.program.ssa import Argument, Op, Program

from .strategies import POINTS, SYMBOLS, programs

x, y, z = sympy.symbols("x y z", real=True)
ARGUMENTS = (Argument("v", ("x", "y", "z")),)
AT = (1.25, -0.75, 0.375)


@settings(deadline=None)
@given(program=programs(smooth=True, size=20))
def test_jacobians_agree_with_central_differences(program: Program) -> None:
    jacobian = differentiate(program, SYMBOLS, "J")
    assert jacobian.shape == (*program.shape, 3)
    point = POINTS[0]
    got = evaluate(jacobian, point, dps=50)
    with mpmath.workdps(50):
        step = mpmath.mpf(10) ** -17
        flat = [mpmath.mpf(v) for values in point.values() for v in values]
        for column in range(3):
            sides = []
            for sign in (1, -1):
                moved = [v + sign * step * (index == column) for index, v in enumerate(flat)]
                sides.append(evaluate(program, {"x": moved[:2], "p": moved[2:]}, dps=50))
            for row, (ahead, behind) in enumerate(zip(*sides, strict=True)):
                expected = (ahead - behind) / (2 * step)
                scale = 1 + abs(expected) + abs(ahead)
                assert abs(got[3 * row + column] - expected) <= mpmath.mpf("1e-12") * scale


@pytest.mark.parametrize(
    "expression",
    [
        x * y - y / x,
        sympy.sin(x * y) + sympy.cos(x - z),
        sympy.tan(z) * sympy.tanh(x),
        sympy.exp(y) * sympy.log(x) * sympy.sqrt(z),
        sympy.atan2(x, y) + sympy.atan2(y, x * z),
        sympy.Abs(y) * x + sympy.sign(y) * z,
        deadzone(x, z) + deadzone(y, z) * x,
        sympy.exp(-((y / z) ** 2)),
    ],
)
def test_every_rule_agrees_with_sympy(expression: sympy.Expr) -> None:
    jacobian = differentiate(lower("f", ARGUMENTS, (), (expression,), ()), ("x", "y", "z"), "J")
    exact = {s: sympy.Rational(v) for s, v in zip((x, y, z), AT, strict=True)}
    got = evaluate(jacobian, {"v": AT})
    for s, derivative in zip((x, y, z), got, strict=True):
        expected = float(sympy.diff(expression, s).subs(exact).doit().evalf(30))
        assert float(derivative) == pytest.approx(expected, rel=1e-13, abs=1e-15)


@pytest.mark.parametrize(("function", "picks_x"), [(sympy.Min, False), (sympy.Max, True)])
def test_minimum_and_maximum_take_the_branch_that_holds(function: type[sympy.Expr], picks_x: bool) -> None:
    jacobian = differentiate(lower("f", ARGUMENTS, (), (function(x * x, y),), ()), ("x", "y"), "J")
    assert evaluate(jacobian, {"v": AT}) == ([2 * AT[0], 0] if picks_x else [0, 1])


def test_jumps_have_no_derivative() -> None:
    nodes = lower("f", ARGUMENTS, (), (sympy.sign(x * y),), ())
    jacobian = differentiate(nodes, ("x", "y"), "J")
    assert [node.op for node in jacobian.nodes] == [Op.CONST]


def test_structural_zeros_are_never_computed() -> None:
    program = lower("f", ARGUMENTS, (), (sympy.sin(x), 3 * y, z), (3,))
    jacobian = differentiate(program, ("x", "y", "z"), "J")
    assert count(jacobian) == Cost(0, 0, 0, 1, 0)
    assert evaluate(jacobian, {"v": (0.0, 1.0, 1.0)}) == [1, 0, 0, 0, 3, 0, 0, 0, 1]


def test_columns_follow_the_order_asked_for() -> None:
    program = lower("f", ARGUMENTS, (), (2 * x + 5 * z,), ())
    assert evaluate(differentiate(program, ("z", "y", "x"), "J"), {"v": AT}) == [5, 0, 2]


@pytest.mark.parametrize("wrt", [("nobody",), ("x", "x")])
def test_bad_variables_are_refused(wrt: tuple[str, ...]) -> None:
    with pytest.raises(ProgramError, match="SD814"):
        differentiate(lower("f", ARGUMENTS, (), (x,), ()), wrt, "J")
