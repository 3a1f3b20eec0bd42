"""Lowering agrees with SymPy, refuses what has no meaning, and repeats byte for byte."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import mpmath
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

import symdyn
from symdyn.base.nonsmooth import clip, deadzone, outside, quantise, sign_of, step
from symdyn.derive.steps import Step
from symdyn.program.cost import Cost, count
from symdyn.program.describe import describe
from symdyn.program.errors import ProgramError
from symdyn.program.evaluate import evaluate
from symdyn.program.lower import lower
from symdyn.program.ssa import Argument, Op, Program

x, y, z = sympy.symbols("x y z", real=True)
ARGUMENTS = (Argument("v", ("x", "y", "z")),)
POINT = {x: sympy.Rational(13, 7), y: sympy.Rational(-5, 3), z: sympy.Rational(3, 11)}


def program(*outputs: sympy.Expr, steps: tuple[Step, ...] = ()) -> Program:
    return lower("f", ARGUMENTS, steps, outputs, (len(outputs),))


def value(expression: sympy.Expr, point: dict[sympy.Symbol, sympy.Rational] = POINT) -> mpmath.mpf:
    at = [mpmath.mpf(point[s].p) / point[s].q for s in (x, y, z)]
    return evaluate(program(expression), {"v": at}, dps=15)[0]


def agrees(expression: sympy.Expr) -> bool:
    expected = float(expression.subs(POINT).evalf(30))
    return abs(float(value(expression)) - expected) <= 1e-12 * (1 + abs(expected))


def _combine(inner: st.SearchStrategy[sympy.Expr]) -> st.SearchStrategy[sympy.Expr]:
    positive = inner.map(lambda e: 3 + sympy.sin(e))
    functions = st.sampled_from((sympy.sin, sympy.cos, sympy.tanh, sign_of, step, sympy.sign, sympy.Abs))
    return st.one_of(
        st.lists(inner, min_size=2, max_size=4).map(lambda args: sympy.Add(*args)),
        st.lists(inner, min_size=2, max_size=4).map(lambda args: sympy.Mul(*args)),
        st.tuples(functions, inner).map(lambda pair: pair[0](pair[1])),
        st.tuples(positive, st.sampled_from((-3, -2, -1, 2, 3, "1/2", "-1/2", "3/2", "-5/2"))).map(
            lambda pair: pair[0] ** sympy.Rational(pair[1])
        ),
        st.tuples(inner, positive).map(lambda pair: pair[0] / pair[1]),
        st.tuples(positive, st.sampled_from((sympy.sqrt, sympy.log))).map(lambda pair: pair[1](pair[0])),
        inner.map(lambda e: sympy.exp(sympy.sin(e))),
        inner.map(lambda e: deadzone(e, sympy.Rational(1, 5))),
        inner.map(lambda e: outside(e, sympy.Rational(1, 5))),
        inner.map(lambda e: clip(e, sympy.Rational(-1, 5), sympy.Rational(2, 5))),
        inner.map(lambda e: quantise(e, sympy.Rational(1, 7))),
        st.tuples(inner, positive).map(lambda pair: sympy.atan2(*pair)),
    )


_ATOMS = (x, y, z, sympy.Rational(2, 3), sympy.Integer(-2), sympy.pi, sympy.Float(0.3))


@settings(deadline=None)
@given(st.recursive(st.sampled_from(_ATOMS), _combine, max_leaves=6))
def test_lowering_agrees_with_sympy(expression: sympy.Expr) -> None:
    assert agrees(expression)


@pytest.mark.parametrize("function", [sympy.Min, sympy.Max])
def test_minimum_and_maximum_of_many(function: type[sympy.Expr]) -> None:
    assert agrees(function(x, y * y, z, sympy.Rational(1, 3)))


@pytest.mark.parametrize(
    "expression",
    [
        -x - y,
        -(x * y) * z,
        x / y / z,
        (-z) ** 3 * x,
        sympy.tan(x) + sympy.E,
        x**-1 + y**-2,
        (-y) ** sympy.Rational(3, 2),
        sympy.Pow(x / z, 1, evaluate=False) * y,
        sympy.Mul(sympy.Integer(-1), sympy.Integer(-1), x, evaluate=False),
        sympy.sqrt(2) * x,
        sympy.Pow(-x, 2, evaluate=False),
        sympy.Pow(-y, 3, evaluate=False) * z,
        sympy.Pow(-y, -2, evaluate=False) * z,
        sympy.atan(x * y),
        (2 + y**2) ** (x / 3) * (3 + x**2) ** sympy.Rational(-2, 3) / x,
        sympy.Integer(0),
    ],
)
def test_particular_forms(expression: sympy.Expr) -> None:
    assert agrees(expression)


@pytest.mark.parametrize(
    ("expression", "cost"),
    [
        (x / y / z, Cost(0, 1, 1, 0, 0)),  # one division by the product
        (-x * y + z, Cost(1, 1, 0, 0, 0)),  # a subtraction, no change of sign
        (x**8, Cost(0, 3, 0, 0, 0)),  # repeated squaring
        (sympy.sin(x) * y + sympy.sin(x) * z, Cost(1, 2, 0, 1, 0)),  # equal lines are one line
    ],
)
def test_forms_are_cheap(expression: sympy.Expr, cost: Cost) -> None:
    assert count(program(expression)) == cost


def test_rationals_are_rounded_once() -> None:
    nodes = program(sympy.Rational(10**40 + 1, 3 * 10**40) * x).nodes
    assert [node.value for node in nodes if node.op is Op.CONST] == [1 / 3]


@pytest.mark.parametrize("at", [(2.0, 0.5), (-2.0, 0.5), (0.2, 0.5), (-0.2, 0.5), (0.5, 0.5), (-0.5, 0.5), (0.0, 0.0)])
def test_gap_functions_mean_what_they_say(at: tuple[float, float]) -> None:
    u, s = at
    expected = u - s if u > s else u + s if u < -s else 0.0
    got = evaluate(program(deadzone(x, y), outside(x, y), deadzone(-x, y, evaluate=False)), {"v": (u, s, 0.0)})
    assert got == [expected, float(abs(u) > s), -expected]


def test_steps_name_their_lines_and_carry_their_origin() -> None:
    u, w = sympy.symbols("u w")
    steps = (Step(u, x + y, "link 1: speed"), Step(w, sympy.sin(u) * z, "link 2: force"))
    result = program(w * u, steps=steps)
    named = {node.name: node for node in result.nodes if node.op not in (Op.INPUT, Op.CONST) and node.name}
    assert {name: (node.op, node.origin) for name, node in named.items()} == {
        "u": (Op.ADD, "link 1: speed"),
        "w": (Op.MUL, "link 2: force"),
    }
    assert agrees((x + y) * sympy.sin(x + y) * z)
    at = {"v": (0.3, 0.4, 0.5)}
    assert evaluate(result, at) == evaluate(program((x + y) * sympy.sin(x + y) * z), at)


def test_an_unknown_symbol_is_named() -> None:
    with pytest.raises(ProgramError, match=r"SD811: unknown symbol stranger \(known: x, y, z"):
        program(x + sympy.Symbol("stranger"))


def test_a_step_may_not_use_a_later_one() -> None:
    u, w = sympy.symbols("u w")
    with pytest.raises(ProgramError, match="unknown symbol w"):
        program(u, steps=(Step(u, w + x, ""), Step(w, y, "")))


def test_a_symbol_may_not_be_defined_twice() -> None:
    with pytest.raises(ProgramError, match="SD811: the symbol x is defined twice"):
        program(x, steps=(Step(x, y + z, ""),))


@pytest.mark.parametrize(
    ("expression", "code"),
    [
        (x**y, "SD812"),
        (x ** sympy.Rational(1, 3), "SD812"),
        (sympy.gamma(x), "SD812"),
        (sympy.DiracDelta(x), "SD812"),
        (sympy.Function("g")(x), "SD812"),
        (sympy.Derivative(sympy.Function("g")(x), x), "SD812"),
        (sympy.oo + x, "SD815"),
        (sympy.nan, "SD815"),
        (sympy.Integer(10) ** 400 * x, "SD815"),
        (sympy.I * x, "SD812"),
    ],
)
def test_what_has_no_meaning_is_refused(expression: sympy.Expr, code: str) -> None:
    with pytest.raises(ProgramError) as caught:
        program(expression)
    assert [problem.code for problem in caught.value.problems] == [code]


def test_a_name_that_is_code_is_refused() -> None:
    hostile = '__import__("os")'
    with pytest.raises(ProgramError, match="SD813"):
        lower("f", (Argument("v", (hostile,)),), (), (sympy.Symbol(hostile),), (1,))


def test_depth_has_no_limit() -> None:
    deep = x
    for _ in range(3000):
        deep = sympy.Add(sympy.Mul(deep, y, evaluate=False), z, evaluate=False)
    assert count(program(deep)) == Cost(3000, 3000, 0, 0, 0)


_SCRIPT = """
import sympy
from symdyn.derive.steps import Step
from symdyn.program.describe import describe
from symdyn.program.differentiate import differentiate
from symdyn.program.lower import lower
from symdyn.program.optimize import optimize
from symdyn.program.ssa import Argument
v = sympy.symbols("v_1:7", real=True)
w = sympy.Symbol("w", real=True)
total = sum(sympy.sin(a) * sympy.cos(b) / (2 + sympy.cos(a)) + sympy.Max(a, b, 1) * a * b for a in v for b in v)
arguments = (Argument("v", tuple(str(s) for s in v)),)
program = lower("f", arguments, (Step(w, total, "sum"),), (w * total, sympy.Min(*v) * w), (2,))
print(describe(program))
print(describe(optimize(differentiate(program, ("v_2", "v_5"), "J")).program))
"""


def test_programs_do_not_depend_on_the_hash_seed() -> None:
    root = str(Path(symdyn.__file__).parents[1])
    listings = []
    for seed in ("1", "271828"):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": root}
        command = [sys.executable, "-c", _SCRIPT]
        run = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        listings.append(run.stdout)
    assert len(listings[0].splitlines()) > 100
    assert listings[0] == listings[1]


def test_the_order_in_which_sympy_stores_arguments_does_not_matter() -> None:
    def listing(turn: Callable[[list[sympy.Expr]], list[sympy.Expr]]) -> str:
        def total(*terms: sympy.Expr) -> sympy.Expr:
            return sympy.Add(*turn(list(terms)), evaluate=False)

        inner = [sympy.sin(total(s, x * y, 3 * s, z)) for s in (x, y, z, x * z, y * z, x / y)]
        return describe(program(total(*inner, x * y, z, sympy.Rational(1, 3) * y)))

    assert listing(lambda terms: terms) == listing(lambda terms: terms[::-1])
