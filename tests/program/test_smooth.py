"""Smoothed jumps: the stated slope and nothing else; away from a jump the program means what it meant."""

from __future__ import annotations

import mpmath
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.base.nonsmooth import sign_of, step
from symdyn.program.builder import Builder
from symdyn.program.differentiate import differentiate
from symdyn.program.evaluate import evaluate
from symdyn.program.lower import lower
from symdyn.program.smooth import smooth
from symdyn.program.ssa import Argument, Op, Program

from .strategies import POINTS, programs

x, k = sympy.symbols("x k", real=True)
ARGUMENTS = (Argument("q", ("x",)), Argument("p", ("k",)))


def program(*outputs: sympy.Expr) -> Program:
    return lower("force", ARGUMENTS, (), outputs, (len(outputs),))


JUMPS = program(sign_of(x), step(x))


def at(of: Program, position: float, stiffness: float = 2.0) -> list[float]:
    return [float(value) for value in evaluate(of, {"q": (position,), "p": (stiffness,)}, 40)]


@settings(deadline=None)
@given(position=st.floats(-5, 5), width=st.floats(1e-3, 3.0))
def test_sign_and_step_become_hyperbolic_tangents_of_that_width(position: float, width: float) -> None:
    slope = mpmath.tanh(mpmath.mpf(position) / mpmath.mpf(width))
    assert at(smooth(JUMPS, width), position) == pytest.approx([float(slope), float((1 + slope) / 2)], abs=1e-13)


@pytest.mark.parametrize("width", [1e-3, 0.1, 2.0])
def test_slope_at_the_jump_is_one_over_the_width(width: float) -> None:
    slope = differentiate(smooth(JUMPS, width), ("x",), "slope")
    assert at(slope, 0.0) == pytest.approx([1.0 / width, 0.5 / width], rel=1e-12)
    assert at(differentiate(JUMPS, ("x",), "slope"), 0.0) == [0.0, 0.0]


@pytest.mark.parametrize("position", [-0.3, -0.02, 0.02, 0.3])
def test_narrow_slope_is_the_jump_away_from_it(position: float) -> None:
    assert at(smooth(JUMPS, 1e-3), position) == pytest.approx(at(JUMPS, position), abs=1e-14)


def test_halfway_between_the_two_levels_at_the_jump() -> None:
    assert at(smooth(JUMPS, 0.1), 0.0) == [0.0, 0.5]


def test_argument_of_the_jump_may_be_anything() -> None:
    composite = smooth(program(k * sign_of(x**2 - k) + x), 0.25)
    for position in (-2.0, 0.7, 1.5):
        expected = 2.0 * float(mpmath.tanh((position**2 - 2.0) / 0.25)) + position
        assert at(composite, position) == pytest.approx([expected], rel=1e-13)


def test_jump_within_a_jump_is_smoothed_from_the_inside_out() -> None:
    nested = program(sign_of(step(x) - sympy.Rational(1, 4)))
    inner = (1 + mpmath.tanh(mpmath.mpf(0.05) / mpmath.mpf(0.1))) / 2
    expected = float(mpmath.tanh((inner - mpmath.mpf(0.25)) / mpmath.mpf(0.1)))
    assert at(smooth(nested, 0.1), 0.05) == pytest.approx([expected], rel=1e-12)


def test_of_speeds_with_widths_of_their_own_only_what_depends_on_them_is_smoothed() -> None:
    y = sympy.Symbol("y", real=True)
    made = smooth(
        lower("force", (Argument("q", ("x",)), Argument("v", ("y", "z"))), (), (sign_of(x), sign_of(y), step(y)), (3,)),
        {"y": 0.1, "z": 0.01},
    )
    assert [node.op for node in made.nodes].count(Op.TANH) == 1
    found = evaluate(made, {"q": (0.01,), "v": (0.05, 0.0)}, 30)
    assert [float(value) for value in found] == pytest.approx([1.0, float(mpmath.tanh(0.5)), 1.0])


def test_the_narrowest_width_of_several_speeds_counts() -> None:
    y, z = sympy.symbols("y z", real=True)
    made = smooth(lower("force", (Argument("v", ("y", "z")),), (), (sign_of(y - z),), (1,)), {"y": 0.1, "z": 0.01})
    assert float(evaluate(made, {"v": (0.005, 0.0)}, 30)[0]) == pytest.approx(float(mpmath.tanh(0.5)))


@settings(deadline=None)
@given(random=programs())
def test_no_jump_is_left_and_the_interface_stays(random: Program) -> None:
    smoothed = smooth(random, 0.5)
    assert not {Op.SIGN, Op.STEP} & {node.op for node in smoothed.nodes}
    assert (smoothed.name, smoothed.arguments, smoothed.shape) == (random.name, random.arguments, random.shape)


@settings(deadline=None)
@given(random=programs(smooth=True))
def test_program_without_jumps_keeps_every_digit(random: Program) -> None:
    for point in POINTS:
        assert evaluate(smooth(random, 0.5), point, 30) == evaluate(random, point, 30)


def test_names_of_lines_that_stay_are_kept() -> None:
    builder = Builder()
    line = builder.intern(Op.SIN, (builder.input("x"),), "link 1: position")
    builder.label(line, "height")
    jump = builder.intern(Op.SIGN, (line,), "friction")
    made = smooth(builder.program("force", ARGUMENTS, (jump,), (1,)), 0.1)
    assert [(node.op, node.origin) for node in made.nodes if node.name == "height"] == [(Op.SIN, "link 1: position")]


@pytest.mark.parametrize("width", [0.0, -1.0, float("nan")])
def test_width_that_is_none_is_refused(width: float) -> None:
    with pytest.raises(ValueError, match="width"):
        smooth(JUMPS, width)
    with pytest.raises(ValueError, match="width"):
        smooth(JUMPS, {"x": 1.0, "k": width})
