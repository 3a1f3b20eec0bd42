"""Inlining a program into a builder keeps its meaning, alone, twice, and with inputs replaced by lines."""

from __future__ import annotations

from collections.abc import Mapping

import mpmath
import pytest
from hypothesis import assume, given, settings

from symdyn.program.builder import Builder
from symdyn.program.compose import inline
from symdyn.program.errors import ProgramError
from symdyn.program.evaluate import evaluate
from symdyn.program.ssa import Argument, Op, Program

from .strategies import ARGUMENTS, POINTS, programs

Point = Mapping[str, tuple[float, ...]]
DIGITS = 50


def same(found: list[mpmath.mpf], expected: list[mpmath.mpf]) -> bool:
    return len(found) == len(expected) and all(
        abs(a - b) <= mpmath.mpf(10) ** -40 * (1 + abs(b)) for a, b in zip(found, expected, strict=True)
    )


def built(builder: Builder, outputs: tuple[int, ...]) -> Program:
    return builder.program("composed", ARGUMENTS, outputs, (len(outputs),))


@settings(deadline=None)
@given(program=programs())
def test_program_in_an_empty_builder_is_itself(program: Program) -> None:
    builder = Builder()
    copy = built(builder, inline(builder, program))
    for point in POINTS:
        assert evaluate(copy, point, DIGITS) == evaluate(program, point, DIGITS)
    assert len(copy.nodes) == len(program.nodes)


@settings(deadline=None)
@given(first=programs(size=15), second=programs(size=15))
def test_two_programs_side_by_side_keep_their_outputs(first: Program, second: Program) -> None:
    builder = Builder()
    both = built(builder, (*inline(builder, first), *inline(builder, second)))
    for point in POINTS:
        expected = evaluate(first, point, DIGITS) + evaluate(second, point, DIGITS)
        assert same(evaluate(both, point, DIGITS), expected)


@settings(deadline=None)
@given(program=programs())
def test_a_second_copy_costs_nothing(program: Program) -> None:
    builder = Builder()
    once = inline(builder, program)
    size = len(builder)
    assert inline(builder, program) == once
    assert len(builder) == size


@settings(deadline=None)
@given(outer=programs(smooth=True, size=15), inner=programs(smooth=True, size=15))
def test_output_of_one_as_input_of_the_other_is_the_composed_function(outer: Program, inner: Program) -> None:
    builder = Builder()
    line = inline(builder, inner)[0]
    composed = built(builder, inline(builder, outer, {"x_2": line}))
    for point in POINTS:
        between = evaluate(inner, point, DIGITS)[0]
        assume(abs(between) < 1e6)
        expected = evaluate(outer, {"x": (point["x"][0], between), "p": point["p"]}, DIGITS)
        assert same(evaluate(composed, point, DIGITS), expected)


def square_minus(name: str) -> Program:
    """x_1^2 - x_2, with a named line in it."""
    builder = Builder()
    one, two = builder.input("x_1"), builder.input("x_2")
    square = builder.intern(Op.MUL, (one, one), "link 1: speed")
    builder.label(square, "square")
    return builder.program(name, ARGUMENTS, (builder.intern(Op.SUB, (square, two)),), (1,))


def test_inputs_replaced_crosswise_do_not_catch_each_other() -> None:
    builder = Builder()
    one, two = builder.input("x_1"), builder.input("x_2")
    crossed = built(builder, inline(builder, square_minus("f"), {"x_1": two, "x_2": one}))
    (found,) = evaluate(crossed, {"x": (3.0, 5.0), "p": (0.0,)})
    assert found == 5.0**2 - 3.0


def test_input_replaced_by_a_constant_is_gone() -> None:
    builder = Builder()
    bound = built(builder, inline(builder, square_minus("f"), {"x_1": builder.constant(4.0)}))
    assert [node.name for node in bound.nodes if node.op is Op.INPUT] == ["x_2"]
    assert evaluate(bound, {"x": (77.0, 1.0), "p": (0.0,)}) == [15.0]


def test_name_that_is_no_input_of_the_program_replaces_nothing() -> None:
    builder = Builder()
    plain = built(builder, inline(builder, square_minus("f"), {"square": builder.constant(0.0)}))
    assert evaluate(plain, {"x": (3.0, 5.0), "p": (0.0,)}) == [4.0]


def test_names_and_origins_travel_and_stay_unique() -> None:
    builder = Builder()
    first = inline(builder, square_minus("f"))
    second = inline(builder, square_minus("g"), {"x_1": builder.input("x_3")})
    both = built(builder, (*first, *second))
    named = [node for node in both.nodes if node.name == "square"]
    assert [(node.op, node.origin) for node in named] == [(Op.MUL, "link 1: speed")]
    assert evaluate(both, {"x": (3.0, 5.0), "p": (7.0,)}) == [4.0, 44.0]


def test_inputs_that_no_argument_of_the_new_program_holds_are_refused() -> None:
    builder = Builder()
    outputs = inline(builder, square_minus("f"))
    with pytest.raises(ProgramError, match="x_2") as caught:
        builder.program("composed", (Argument("x", ("x_1",)),), outputs, (1,))
    assert [problem.code for problem in caught.value.problems] == ["SD813"]
