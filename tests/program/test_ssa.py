"""A program is checked when it is made; its listing and its evaluator say what it means."""

from __future__ import annotations

import math

import mpmath
import pytest

from symdyn.program.builder import Builder
from symdyn.program.cost import Cost, count
from symdyn.program.describe import describe
from symdyn.program.errors import ProgramError
from symdyn.program.evaluate import evaluate
from symdyn.program.ssa import Argument, Node, Op, Program, arity

X = Node(Op.INPUT, name="x")
ONE = Node(Op.CONST, value=1.0)
ARGUMENTS = (Argument("v", ("x", "y")),)


def make(
    *nodes: Node, name: str = "f", arguments: tuple[Argument, ...] = ARGUMENTS, shape: tuple[int, ...] = ()
) -> Program:
    return Program(name, arguments, nodes, (len(nodes) - 1,), shape)


@pytest.mark.parametrize(
    ("nodes", "message"),
    [
        ((X, Node(Op.SIN, (1,))), "does not come before"),
        ((X, Node(Op.SIN, (-1,))), "does not come before"),
        ((X, Node(Op.ADD, (0,))), "takes 2 arguments, not 1"),
        ((Node(Op.CONST),), "constants, and only they"),
        ((X, Node(Op.SIN, (0,), value=1.0)), "constants, and only they"),
        ((Node(Op.CONST, value=float("inf")),), "not finite"),
        ((Node(Op.INPUT, name="z"),), "belongs to no argument"),
        ((X, X), "more than once"),
        ((X, Node(Op.SIN, (0,), name="w"), Node(Op.COS, (0,), name="w")), "w appears more than once"),
        ((X, Node(Op.SIN, (0,), name="y")), "y appears more than once"),
        ((X, Node(Op.SIN, (0,), name="a b")), "not an identifier"),
        ((X, Node(Op.SIN, (0,), origin="law\nimport os")), "line break"),
    ],
)
def test_malformed_programs_are_refused(nodes: tuple[Node, ...], message: str) -> None:
    with pytest.raises(ProgramError, match=message):
        make(*nodes)


@pytest.mark.parametrize("name", ["", "lambda", "a b", "ﬁ", "f()", "1f"])
def test_names_are_identifiers(name: str) -> None:
    make(X)
    for broken in (
        lambda: make(X, name=name),
        lambda: make(X, arguments=(Argument(name, ("x",)),)),
        lambda: make(X, arguments=(Argument("v", ("x", name)),)),
    ):
        with pytest.raises(ProgramError, match="not an identifier"):
            broken()


def test_outputs_exist_and_fill_the_shape() -> None:
    with pytest.raises(ProgramError, match="does not exist"):
        Program("f", ARGUMENTS, (X,), (1,), ())
    with pytest.raises(ProgramError, match="do not fill the shape"):
        make(X, shape=(2,))


def test_equal_operations_are_one_line() -> None:
    builder = Builder()
    x, y = builder.input("x"), builder.input("y")
    assert builder.intern(Op.ADD, (x, y)) == builder.intern(Op.ADD, (y, x))
    assert builder.intern(Op.SUB, (x, y)) != builder.intern(Op.SUB, (y, x))
    zero = builder.constant(-0.0)
    assert zero == builder.constant(0.0)
    assert math.copysign(1.0, builder.values[zero]) == 1.0


def test_the_first_label_stays_and_labels_are_unique() -> None:
    builder = Builder()
    x = builder.input("x")
    first, second = builder.intern(Op.SIN, (x,)), builder.intern(Op.COS, (x,))
    for line, label in ((first, "a"), (first, "b"), (second, "a")):
        builder.label(line, label)
    nodes = builder.program("f", ARGUMENTS, (first, second), (2,)).nodes
    assert [node.name for node in nodes] == ["x", "a", None]


def test_counts_by_kind() -> None:
    nodes = [X, Node(Op.INPUT, name="y"), ONE]
    nodes += [Node(op, (0, 1)[: arity(op)]) for op in Op if arity(op)]
    program = make(*nodes)
    assert count(program) == Cost(3, 1, 1, 3, 11)
    assert count(program).lines == len(nodes) - 3


def test_listing() -> None:
    program = make(X, ONE, Node(Op.ADD, (0, 1), name="w", origin="law"), Node(Op.SIN, (2,)))
    assert describe(program).splitlines() == [
        "f(v[2]) -> scalar",
        "%0 = input x",
        "%1 = 1.0",
        "%2 = add %0 %1  # w: law",
        "%3 = sin %2",
        "return %3",
    ]


@pytest.mark.parametrize(
    ("op", "at", "expected"),
    [
        (Op.ADD, (2, 3), 5), (Op.SUB, (2, 3), -1), (Op.MUL, (2, 3), 6), (Op.DIV, (3, 2), 1.5), (Op.NEG, (2, 0), -2),
        (Op.SIN, (0, 0), 0), (Op.COS, (0, 0), 1), (Op.TAN, (0, 0), 0), (Op.TANH, (0, 0), 0), (Op.EXP, (0, 0), 1),
        (Op.LOG, (1, 0), 0), (Op.SQRT, (9, 0), 3), (Op.ABS, (-3, 0), 3), (Op.MIN, (2, 3), 2), (Op.MAX, (2, 3), 3),
        (Op.SIGN, (-3, 0), -1), (Op.SIGN, (0, 0), 0), (Op.SIGN, (3, 0), 1),
        (Op.STEP, (-3, 0), 0), (Op.STEP, (0, 0), 0), (Op.STEP, (3, 0), 1), (Op.ATAN2, (0, 1), 0),
        (Op.FLOOR, (2.5, 0), 2), (Op.FLOOR, (-2.5, 0), -3), (Op.FLOOR, (-2, 0), -2),
        (Op.DIV, (1, 0), mpmath.inf), (Op.DIV, (-1, 0), -mpmath.inf), (Op.LOG, (0, 0), -mpmath.inf),
    ],
)  # fmt: skip
def test_the_meaning_of_each_operation(op: Op, at: tuple[float, float], expected: float) -> None:
    program = make(X, Node(Op.INPUT, name="y"), Node(op, (0, 1)[: arity(op)]))
    assert evaluate(program, {"v": at}) == [expected]


@pytest.mark.parametrize(("op", "at"), [(Op.SQRT, (-1, 0)), (Op.LOG, (-1, 0)), (Op.DIV, (0, 0))])
def test_what_has_no_real_value_is_not_a_number(op: Op, at: tuple[float, float]) -> None:
    program = make(X, Node(Op.INPUT, name="y"), Node(op, (0, 1)[: arity(op)]))
    assert mpmath.isnan(evaluate(program, {"v": at})[0])


def test_the_evaluator_has_the_digits_it_is_asked_for() -> None:
    program = make(X, Node(Op.SIN, (0,)))
    with mpmath.workdps(60):
        exact = mpmath.sin(mpmath.mpf(1))
        assert abs(evaluate(program, {"v": (1, 0)}, dps=50)[0] - exact) < mpmath.mpf("1e-49")
        assert abs(evaluate(program, {"v": (1, 0)}, dps=20)[0] - exact) > mpmath.mpf("1e-30")


@pytest.mark.parametrize("inputs", [{}, {"v": (1.0,)}, {"v": (1.0, 2.0), "u": ()}])
def test_wrong_inputs_are_refused(inputs: dict[str, tuple[float, ...]]) -> None:
    with pytest.raises(ProgramError, match="SD814"):
        evaluate(make(X), inputs)
