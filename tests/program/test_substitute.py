"""Binding inputs to numbers keeps the value and leaves nothing of what they made constant."""

from __future__ import annotations

import pytest
import sympy
from hypothesis import given, settings

from symdyn.program.cost import Cost, count
from symdyn.program.errors import ProgramError
from symdyn.program.evaluate import evaluate
from symdyn.program.lower import lower
from symdyn.program.ssa import Argument, Op, Program
from symdyn.program.substitute import bind

from .strategies import ARGUMENTS, POINTS, programs

q, m, r = sympy.symbols("q m r", real=True)
PENDULUM = lower(
    "torque", (Argument("q", ("q",)), Argument("p", ("m", "r"))), (), (m * r * 9.81 * sympy.sin(q) + m * r**2 * q,), ()
)


@settings(deadline=None)
@given(program=programs())
def test_binding_keeps_the_value(program: Program) -> None:
    for point in POINTS:
        bound = bind(program, {"x_3": point["p"][0]}, drop=("p",))
        assert bound.arguments == ARGUMENTS[:1]
        expected = evaluate(program, point, 50)
        for got, exact in zip(evaluate(bound, {"x": point["x"]}, 50), expected, strict=True):
            assert abs(got - exact) <= 1e-9 * (1 + abs(exact))


def test_parameters_fold_into_coefficients() -> None:
    bound = bind(PENDULUM, {"m": 2.0, "r": 0.5}, name="folded", drop=("p",))
    assert (bound.name, bound.symbols) == ("folded", ("q",))
    assert count(bound) == Cost(1, 2, 0, 1, 0)
    assert float(evaluate(bound, {"q": (0.3,)})[0]) == pytest.approx(2 * 0.5 * 9.81 * 0.29552020666134 + 0.5 * 0.3)


def test_an_argument_keeps_its_entries_unless_dropped() -> None:
    bound = bind(PENDULUM, {"m": 2.0})
    assert bound.arguments == PENDULUM.arguments
    assert {node.name for node in bound.nodes if node.op is Op.INPUT} == {"q", "r"}


@pytest.mark.parametrize(
    ("values", "drop", "message"),
    [
        ({"mass": 1.0}, (), "no input mass"),
        ({}, ("s",), "no argument s"),
        ({"m": 1.0}, ("p",), "cannot drop r"),
        ({"m": float("nan")}, (), "must be finite"),
    ],
)
def test_mistakes_are_named(values: dict[str, float], drop: tuple[str, ...], message: str) -> None:
    with pytest.raises(ProgramError, match=message):
        bind(PENDULUM, values, drop=drop)
