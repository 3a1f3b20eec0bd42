"""Each local rule: what it makes of an operation, and that the value is the same."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from symdyn.program import folding
from symdyn.program.builder import Builder
from symdyn.program.cost import count
from symdyn.program.evaluate import evaluate
from symdyn.program.folding import fold
from symdyn.program.passes import collect_terms, fold_constants
from symdyn.program.ssa import NULLARY, Argument, Op, Program, arity

ARGUMENTS = (Argument("v", ("x", "y")),)
POINTS = ((1.25, -0.375), (-2.5, 0.8125))

Make = Callable[..., int]
Recipe = Callable[[Make, int, int, Callable[[float], int]], int]


def build(recipe: Recipe) -> Program:
    """The recipe's lines as they stand, without any rule."""
    builder = Builder()
    x, y = builder.input("x"), builder.input("y")
    line = recipe(lambda op, *args: builder.intern(op, args), x, y, builder.constant)
    return builder.program("f", ARGUMENTS, (line,), ())


RULES: list[tuple[str, Recipe, int]] = [  # what is folded, and the operations that remain
    ("x + 0", lambda f, x, y, c: f(Op.ADD, x, c(0.0)), 0),
    ("x + -y", lambda f, x, y, c: f(Op.ADD, x, f(Op.NEG, y)), 1),
    ("-x + y", lambda f, x, y, c: f(Op.ADD, f(Op.NEG, x), y), 1),
    ("(x - y) + y", lambda f, x, y, c: f(Op.ADD, f(Op.SUB, x, y), y), 0),
    ("2 + (x + 3)", lambda f, x, y, c: f(Op.ADD, c(2.0), f(Op.ADD, x, c(3.0))), 1),
    ("x - x", lambda f, x, y, c: f(Op.SUB, x, x), 0),
    ("x - 0", lambda f, x, y, c: f(Op.SUB, x, c(0.0)), 0),
    ("0 - x", lambda f, x, y, c: f(Op.SUB, c(0.0), x), 1),
    ("x - -y", lambda f, x, y, c: f(Op.SUB, x, f(Op.NEG, y)), 1),
    ("(x + y) - x", lambda f, x, y, c: f(Op.SUB, f(Op.ADD, x, y), x), 0),
    ("(x + y) - y", lambda f, x, y, c: f(Op.SUB, f(Op.ADD, x, y), y), 0),
    ("x - (x - y)", lambda f, x, y, c: f(Op.SUB, x, f(Op.SUB, x, y)), 0),
    ("x * 0", lambda f, x, y, c: f(Op.MUL, x, c(0.0)), 0),
    ("x * 1", lambda f, x, y, c: f(Op.MUL, x, c(1.0)), 0),
    ("x * -1", lambda f, x, y, c: f(Op.MUL, x, c(-1.0)), 1),
    ("-1 * (x - y)", lambda f, x, y, c: f(Op.MUL, c(-1.0), f(Op.SUB, x, y)), 1),
    ("2 * (x * 3)", lambda f, x, y, c: f(Op.MUL, c(2.0), f(Op.MUL, x, c(3.0))), 1),
    ("2 * -x", lambda f, x, y, c: f(Op.MUL, c(2.0), f(Op.NEG, x)), 1),
    ("-x * -y", lambda f, x, y, c: f(Op.MUL, f(Op.NEG, x), f(Op.NEG, y)), 1),
    ("0 / x", lambda f, x, y, c: f(Op.DIV, c(0.0), x), 0),
    ("x / 1", lambda f, x, y, c: f(Op.DIV, x, c(1.0)), 0),
    ("x / -1", lambda f, x, y, c: f(Op.DIV, x, c(-1.0)), 1),
    ("x / x", lambda f, x, y, c: f(Op.DIV, x, x), 0),
    ("-x / -y", lambda f, x, y, c: f(Op.DIV, f(Op.NEG, x), f(Op.NEG, y)), 1),
    ("x y / y", lambda f, x, y, c: f(Op.DIV, f(Op.MUL, x, y), y), 0),
    ("x y / x", lambda f, x, y, c: f(Op.DIV, f(Op.MUL, x, y), x), 0),
    ("--x", lambda f, x, y, c: f(Op.NEG, f(Op.NEG, x)), 0),
    ("-(x - y)", lambda f, x, y, c: f(Op.NEG, f(Op.SUB, x, y)), 1),
    ("-(2 x)", lambda f, x, y, c: f(Op.NEG, f(Op.MUL, c(2.0), x)), 1),
    ("cos(-x)", lambda f, x, y, c: f(Op.COS, f(Op.NEG, x)), 1),
    ("abs(-x)", lambda f, x, y, c: f(Op.ABS, f(Op.NEG, x)), 1),
    ("abs(abs(x))", lambda f, x, y, c: f(Op.ABS, f(Op.ABS, x)), 1),
    ("abs(exp(x))", lambda f, x, y, c: f(Op.ABS, f(Op.EXP, x)), 1),
    ("abs(sin(x)), which stays", lambda f, x, y, c: f(Op.ABS, f(Op.SIN, x)), 2),
    ("sqrt(x x)", lambda f, x, y, c: f(Op.SQRT, f(Op.MUL, x, x)), 1),
    ("sign(sign(x))", lambda f, x, y, c: f(Op.SIGN, f(Op.SIGN, x)), 1),
    ("step(step(x))", lambda f, x, y, c: f(Op.STEP, f(Op.STEP, x)), 1),
    ("min(x, x)", lambda f, x, y, c: f(Op.MIN, x, x), 0),
    ("max(x, x)", lambda f, x, y, c: f(Op.MAX, x, x), 0),
]


@pytest.mark.parametrize(("recipe", "lines"), [rule[1:] for rule in RULES], ids=[rule[0] for rule in RULES])
def test_each_rule(recipe: Recipe, lines: int) -> None:
    before = build(recipe)
    after = fold_constants(before)
    assert count(after).lines == lines
    for point in POINTS:
        assert evaluate(after, {"v": point}) == evaluate(before, {"v": point})


@pytest.mark.parametrize("op", [op for op in Op if op not in (Op.CONST, Op.INPUT)])
def test_operations_on_numbers_fold(op: Op) -> None:
    one = op in (Op.NEG, Op.SIN, Op.COS, Op.TAN, Op.TANH, Op.EXP, Op.LOG, Op.SQRT, Op.ABS, Op.SIGN, Op.STEP, Op.FLOOR)
    before = build(lambda f, x, y, c: f(op, c(0.75)) if one else f(op, c(0.75), c(-1.5)))
    after = fold_constants(before)
    assert [node.op for node in after.nodes] == [Op.CONST]
    assert float(evaluate(after, {"v": (0, 0)})[0]) == pytest.approx(
        float(evaluate(before, {"v": (0, 0)})[0]), rel=1e-15
    )


@pytest.mark.parametrize(
    "recipe",
    [
        lambda f, x, y, c: f(Op.DIV, c(1.0), c(0.0)),
        lambda f, x, y, c: f(Op.LOG, c(-1.0)),
        lambda f, x, y, c: f(Op.EXP, c(1e4)),
        lambda f, x, y, c: f(Op.MUL, c(1e200), f(Op.MUL, c(1e200), x)),
    ],
)
def test_what_is_not_finite_stays_an_operation(recipe: Recipe) -> None:
    assert count(fold_constants(build(recipe))).lines >= 1


@pytest.mark.parametrize("turned", [(True, False), (False, True), (True, True)])
def test_signs_leave_quotients(turned: tuple[bool, bool]) -> None:
    before = build(
        lambda f, x, y, c: f(
            Op.SUB, x, f(Op.DIV, *(f(Op.NEG, v) if minus else v for v, minus in zip((x, y), turned, strict=True)))
        )
    )
    after = collect_terms(before)
    assert count(after).additions == 1
    assert evaluate(after, {"v": POINTS[0]}) == evaluate(before, {"v": POINTS[0]})


def test_folding_interns_what_no_rule_changes() -> None:
    builder = Builder()
    x, y = builder.input("x"), builder.input("y")
    assert fold(builder, Op.ADD, (x, y)) == builder.intern(Op.ADD, (y, x))


def test_no_rule_applies_where_none_is_tried() -> None:
    """Lines that ``fold`` makes without a look at the rules: the rules would have left them alone."""
    for op in Op:
        if op in NULLARY:
            continue
        for first in Op:
            for second in Op:
                b = Builder()
                args = tuple(sample(b, kind, place) for place, kind in enumerate((first, second)[: arity(op)]))
                tried = not folding.TRIGGERS[op].isdisjoint({b.ops[line] for line in args})
                if not tried and len(set(args)) == len(args):
                    assert folding._number(b, op, args) is None
                    rule = folding._RULES.get(op)
                    assert rule is None or rule(b, args, "") is None


def sample(b: Builder, kind: Op, place: int) -> int:
    """A line of that operation on inputs and numbers that the other argument uses as well."""
    x, y = b.input("x"), b.input("y")
    if kind is Op.CONST:
        return b.constant(2.0 + place)
    if kind is Op.INPUT:
        return (x, y)[place]
    return b.intern(kind, (x, y)[: arity(kind)] if place == 0 else (y, x)[: arity(kind)])
