"""Every pass keeps the value of every program, and none makes one dearer."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import mpmath
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.program.cost import Cost, count, weight
from symdyn.program.evaluate import evaluate
from symdyn.program.lower import lower
from symdyn.program.optimize import DEFAULT, Pass, notable, optimize
from symdyn.program.passes import (
    collect_terms,
    divide_to_reciprocal,
    drop_dead,
    factor_common,
    fold_constants,
    share_subexpressions,
    trigonometric,
)
from symdyn.program.ssa import Argument, Node, Op, Program

from .strategies import POINTS, programs, rotations

q_1, q_2, q_3, a, b, c, d = sympy.symbols("q_1 q_2 q_3 a b c d", real=True)
ARGUMENTS = (Argument("q", ("q_1", "q_2", "q_3")), Argument("p", ("a", "b", "c", "d")))
AT = {"q": (0.3, -1.1, 0.8), "p": (1.7, -0.6, 2.3, 0.9)}


def program(*outputs: sympy.Expr) -> Program:
    return lower("f", ARGUMENTS, (), outputs, (len(outputs),))


def same(before: Sequence[mpmath.mpf], after: Sequence[mpmath.mpf]) -> bool:
    # Constants are doubles: what a pass folds may differ by a rounding, in fifty digits of arithmetic.
    return all(abs(x - y) <= 1e-9 * (1 + abs(x)) for x, y in zip(before, after, strict=True))


def keeps_value(before: Program, after: Program) -> bool:
    return all(same(evaluate(before, point, 50), evaluate(after, point, 50)) for point in POINTS)


@pytest.mark.parametrize("step", DEFAULT, ids=lambda step: step.__name__)
@settings(deadline=None)
@given(before=st.one_of(programs(), rotations()))
def test_a_pass_keeps_the_value_and_never_adds_weight(step: Pass, before: Program) -> None:
    after = step(before)
    assert keeps_value(before, after)
    assert weight(after) <= weight(before)
    assert (after.name, after.arguments, after.shape) == (before.name, before.arguments, before.shape)


@settings(deadline=None)
@given(before=st.one_of(programs(), rotations()))
def test_the_pipeline_keeps_the_value_and_its_table_adds_up(before: Program) -> None:
    result = optimize(before)
    assert keeps_value(before, result.program)
    assert weight(result.program) <= weight(before)
    assert result.costs[0].cost == count(before)
    assert result.costs[-1].cost == count(result.program)
    assert [row.pass_name for row in result.costs if row.round == 1] == [step.__name__ for step in DEFAULT]
    shown = notable(result.costs)
    assert [row for row in shown if row.round < 2] == [row for row in result.costs if row.round < 2]
    assert list(dict.fromkeys(row.cost for row in shown)) == list(dict.fromkeys(row.cost for row in result.costs))
    assert all(row.round < 2 or row.cost != before.cost for before, row in pairwise(shown))


@settings(deadline=None)
@given(before=programs())
def test_passes_are_pure(before: Program) -> None:
    assert optimize(before) == optimize(before)


@pytest.mark.parametrize(
    ("expression", "cost"),
    [
        (a * 0.5 * 4, Cost(0, 1, 0, 0, 0)),
        (a - sympy.Mul(-1, b, evaluate=False), Cost(1, 0, 0, 0, 0)),
        (sympy.Mul(-a, -b, evaluate=False), Cost(0, 1, 0, 0, 0)),
        (sympy.Mul(sympy.Integer(0), a, evaluate=False) + b, Cost(0, 0, 0, 0, 0)),
        (sympy.Add(a, -a, evaluate=False), Cost(0, 0, 0, 0, 0)),
        (sympy.cos(sympy.pi / 7) * a, Cost(0, 1, 0, 0, 0)),
    ],
)
def test_constants_fold(expression: sympy.Expr, cost: Cost) -> None:
    before = program(expression)
    after = fold_constants(before)
    assert count(after) == cost
    assert same(evaluate(before, AT), evaluate(after, AT))


def test_opposite_differences_are_formed_once() -> None:
    after = collect_terms(program((a - b) * c, (b - a) * d + c, sympy.sin(b - a) + sympy.sin(a - b)))
    assert count(after) == Cost(2, 2, 0, 0, 0)


def test_a_sign_is_absorbed_by_the_next_subtraction() -> None:
    turned = -sympy.sin(q_1)
    assert count(collect_terms(program(a + b * (c * turned)))) == Cost(1, 2, 0, 1, 0)


def test_common_factors_leave_a_sum() -> None:
    before = program(a * b + a * c - 2 * a + a * d * d)
    after = factor_common(before)
    assert count(after) == Cost(3, 2, 0, 0, 0)
    assert same(evaluate(before, AT), evaluate(after, AT))


def test_equal_coefficients_leave_a_sum() -> None:
    assert count(factor_common(program(3 * a - 3 * b + 3 * c))) == Cost(2, 1, 0, 0, 0)


def test_pairs_hidden_by_the_order_of_a_chain_are_shared() -> None:
    before = program(a * b * d, a * c * d, sympy.sin(a + b + d), sympy.cos(a + c + d))
    after = share_subexpressions(before)
    assert count(before) == Cost(4, 4, 0, 2, 0)
    assert count(after) == Cost(3, 3, 0, 2, 0)
    assert same(evaluate(before, AT), evaluate(after, AT))


def test_pairs_are_shared_up_to_their_common_sign() -> None:
    before = program(sympy.exp(a + b - c), sympy.exp(d - a - b), sympy.exp(a + b + q_1))
    after = share_subexpressions(before)
    assert count(after).additions == 4
    assert same(evaluate(before, AT), evaluate(after, AT))


def test_powers_of_products_are_squared_together() -> None:
    before = program(a**3 * b**2)
    assert count(collect_terms(before)).multiplications == 3
    assert same(evaluate(before, AT), evaluate(collect_terms(before), AT))


def test_divisions_share_a_reciprocal() -> None:
    after = divide_to_reciprocal(program(a / (b + 1), c / (b + 1), d / (b + 1)))
    assert count(after) == Cost(1, 3, 1, 0, 0)


def test_division_by_a_power_of_two_is_exact() -> None:
    nodes = (Node(Op.INPUT, name="a"), Node(Op.CONST, value=8.0), Node(Op.DIV, (0, 1)))
    after = divide_to_reciprocal(Program("f", ARGUMENTS, nodes, (2,), ()))
    assert [node.value for node in after.nodes if node.op is Op.CONST] == [0.125]
    assert count(after) == Cost(0, 1, 0, 0, 0)


def test_a_lone_division_stays() -> None:
    assert count(divide_to_reciprocal(program(a / b))) == Cost(0, 0, 1, 0, 0)


def test_dead_lines_are_dropped() -> None:
    nodes = (Node(Op.INPUT, name="a"), Node(Op.SIN, (0,)), Node(Op.COS, (0,)), Node(Op.COS, (0,)))
    after = drop_dead(Program("f", ARGUMENTS, nodes, (2, 3), (2,)))
    assert [node.op for node in after.nodes] == [Op.INPUT, Op.COS]
    assert after.outputs == (1, 1)


SUMS = [
    (sympy.cos(q_1) * sympy.cos(q_2) - sympy.sin(q_1) * sympy.sin(q_2), "cos", q_1 + q_2),
    (sympy.cos(q_1) * sympy.cos(q_2) + sympy.sin(q_1) * sympy.sin(q_2), "cos", q_1 - q_2),
    (sympy.sin(q_1) * sympy.cos(q_2) + sympy.cos(q_1) * sympy.sin(q_2), "sin", q_1 + q_2),
    (sympy.sin(q_1) * sympy.cos(q_2) - sympy.cos(q_1) * sympy.sin(q_2), "sin", q_1 - q_2),
]


@pytest.mark.parametrize(("expression", "function", "angle"), SUMS)
@pytest.mark.parametrize("factor", [sympy.Integer(1), -3 * a * b])
def test_angle_sums_are_recognised(
    expression: sympy.Expr, function: str, angle: sympy.Expr, factor: sympy.Expr
) -> None:
    before = program(sympy.expand(factor * expression) + c)
    after = trigonometric(before)
    assert count(after).trigonometric == 1
    assert [node.op for node in after.nodes].count(Op(function)) == 1
    assert same(evaluate(before, AT), evaluate(after, AT))


@pytest.mark.parametrize(
    "expression",
    [
        a * sympy.sin(q_1) ** 2 + a * sympy.cos(q_1) ** 2 + b,
        sympy.sin(q_1) ** 2 * sympy.sin(q_2) + sympy.cos(q_1) ** 2 * sympy.sin(q_2) - sympy.sin(q_2) + a + b,
    ],
)
def test_squares_add_up_to_one(expression: sympy.Expr) -> None:
    before = program(expression)
    after = optimize(before).program
    assert count(after) == Cost(1, 0, 0, 0, 0)
    assert same(evaluate(before, AT), evaluate(after, AT))


@pytest.mark.parametrize("factor", [sympy.Integer(3), a, -2 * a])
def test_one_less_a_square(factor: sympy.Expr) -> None:
    before = program(sympy.cos(q_1), factor - factor * sympy.sin(q_1) ** 2)
    after = trigonometric(before)
    assert count(after).trigonometric == 1
    assert count(after).additions == 0
    assert same(evaluate(before, AT), evaluate(after, AT))


def test_an_angle_sum_that_would_cost_more_is_left_alone() -> None:
    waves = [sympy.sin(q_1), sympy.cos(q_1), sympy.sin(q_2), sympy.cos(q_2)]
    before = program(SUMS[0][0], *waves)  # all four are needed anyway; a fifth is dearer than three operations
    assert count(trigonometric(before)).trigonometric == 4


def test_two_link_gravity_finds_the_sum_of_the_angles() -> None:
    """Gravity torques of the planar two-link arm, from rotations one joint at a time."""
    g, m_1, m_2, l_1, r_1, r_2 = sympy.symbols("g m_1 m_2 l_1 r_1 r_2", real=True)
    arguments = (Argument("q", ("q_1", "q_2")), Argument("p", ("g", "m_1", "m_2", "l_1", "r_1", "r_2")))
    across = sympy.cos(q_1) * sympy.cos(q_2) - sympy.sin(q_1) * sympy.sin(q_2)
    second = sympy.expand(m_2 * r_2 * g * across)
    first = (m_1 * r_1 + m_2 * l_1) * g * sympy.cos(q_1) + second
    before = lower("gravity", arguments, (), (first, second), (2,))
    after = optimize(before).program
    sums = [node for node in after.nodes if node.op is Op.COS and after.nodes[node.args[0]].op is Op.ADD]
    assert len(sums) == 1
    assert count(after).trigonometric == 2  # cos q_1 and cos(q_1 + q_2); there were four
    at = {"q": (0.4, -0.9), "p": (9.81, 1.08, 0.864, 0.5, 0.25, 0.2)}
    assert same(evaluate(before, at), evaluate(after, at))


def test_an_angle_may_itself_be_a_sum() -> None:
    angle = q_1 + q_2
    before = program(sympy.cos(angle) * sympy.cos(q_3) - sympy.sin(angle) * sympy.sin(q_3))
    after = optimize(before).program
    assert count(after) == Cost(2, 0, 0, 1, 0)
    assert same(evaluate(before, AT), evaluate(after, AT))


def test_labels_and_origins_survive_the_pipeline() -> None:
    nodes = (
        Node(Op.INPUT, name="a"),
        Node(Op.INPUT, name="b"),
        Node(Op.MUL, (0, 1), name="power", origin="motor: power"),
        Node(Op.SIN, (2,), origin="sensor"),
        Node(Op.ADD, (2, 3), origin="sum"),
    )
    after = optimize(Program("f", ARGUMENTS, nodes, (4,), ())).program
    product = next(node for node in after.nodes if node.op is Op.MUL)
    assert (product.name, product.origin) == ("power", "motor: power")


def test_the_passes_are_linear_in_depth_and_width() -> None:
    """A chain of 4000 lines and a sum of 2000 terms: neither recursion nor quadratic time."""
    nodes = [Node(Op.INPUT, name="a"), Node(Op.INPUT, name="b")]
    for index in range(2000):
        nodes.append(Node(Op.SIN if index % 3 else Op.TANH, (len(nodes) - 1,)))
        nodes.append(Node(Op.ADD, (len(nodes) - 1, 1)))
    deep = Program("deep", ARGUMENTS, tuple(nodes), (len(nodes) - 1,), ())
    assert count(optimize(deep).program) == count(deep)

    wide = [Node(Op.INPUT, name="a"), Node(Op.SIN, (0,)), Node(Op.SIN, (1,))]
    total = 1
    for _ in range(2000):
        wide.append(Node(Op.SIN, (len(wide) - 1 - (total > 1),)))
        wide.append(Node(Op.ADD, (total, len(wide) - 1)))
        total = len(wide) - 1
    flat = Program("wide", ARGUMENTS, tuple(wide), (total,), ())
    assert weight(optimize(flat).program) <= weight(flat)
