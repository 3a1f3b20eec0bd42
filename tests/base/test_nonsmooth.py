"""Non-smooth primitives: values, symmetry, derivatives without Dirac deltas, and LaTeX."""

from __future__ import annotations

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.base.nonsmooth import absorb, clip, deadzone, is_smooth, outside, quantise, sign_of, step

x, v, k, d = sympy.symbols("x v k d", real=True)
s = sympy.Symbol("S", real=True)

numbers = st.fractions(-3, 3, max_denominator=12).map(lambda f: sympy.Rational(f.numerator, f.denominator))
widths = st.fractions(0, 2, max_denominator=12).map(lambda f: sympy.Rational(f.numerator, f.denominator))


@settings(deadline=None)
@given(numbers, widths)
def test_values_are_exact(u: sympy.Rational, w: sympy.Rational) -> None:
    assert sign_of(u) == int(bool(u > 0)) - int(bool(u < 0))
    assert step(u) == int(bool(u > 0))
    assert outside(u, w) == int(bool(abs(u) > w or w == 0))
    assert deadzone(u, w) == (u - w if u > w else u + w if u < -w else 0)
    assert clip(u, -w, w) == max(-w, min(u, w))
    assert clip(u, -w, 2) == max(-w, min(u, sympy.Integer(2)))
    if w:
        assert quantise(u, w) % w == 0
        assert -w / 2 < quantise(u, w) - u <= w / 2
    else:
        assert quantise(u, w) == u


def test_what_holds_nothing_back_is_the_argument_itself() -> None:
    assert clip(x, -sympy.oo, sympy.oo) == x
    assert quantise(x, 0) == x
    assert quantise(0, s) == 0


def test_bounds_and_quanta_have_a_sense() -> None:
    with pytest.raises(ValueError, match="wrong way round"):
        clip(x, 1, -1)
    with pytest.raises(ValueError, match="cannot be negative"):
        quantise(x, -1)


def test_symmetry() -> None:
    assert sign_of(-x) == -sign_of(x)
    assert deadzone(-x, s) == -deadzone(x, s)
    assert outside(-x, s) == outside(x, s)
    assert deadzone(x, 0) == x
    assert step(-x) != -step(x)


def test_signs_that_are_known() -> None:
    positive = sympy.Symbol("m", positive=True)
    assert (sign_of(positive), sign_of(-positive), step(positive), step(-positive)) == (1, -1, 1, 0)


def test_a_gap_cannot_be_negative() -> None:
    for function in (deadzone, outside):
        with pytest.raises(ValueError, match="cannot be negative"):
            function(x, -1)


def test_derivatives() -> None:
    assert sympy.diff(sign_of(x**2 - v), x) == 0
    assert sympy.diff(step(x), x) == 0
    assert sympy.diff(outside(x, s), x) == sympy.diff(outside(x, s), s) == 0
    assert sympy.diff(deadzone(2 * x, s), x) == 2 * outside(2 * x, s)
    assert sympy.diff(deadzone(x, s), s) == -sign_of(x) * outside(x, s)
    assert sympy.diff(clip(2 * x, -s, s), x) == 2 * step(2 * x + s) * step(s - 2 * x)
    assert sympy.diff(quantise(x, s), x) == 0
    assert sympy.diff(quantise(x, s), s) == quantise(x, s) / s


@pytest.mark.parametrize("u", [sympy.Rational(3, 2), sympy.Rational(-3, 2), sympy.Rational(1, 4)])
def test_derivatives_agree_with_differences(u: sympy.Rational) -> None:
    h, w = sympy.Rational(1, 1000), sympy.Rational(1, 2)
    at = {x: u, s: w}
    assert sympy.diff(deadzone(x, s), x).subs(at) == (deadzone(u + h, w) - deadzone(u - h, w)) / (2 * h)
    assert sympy.diff(deadzone(x, s), s).subs(at) == (deadzone(u, w + h) - deadzone(u, w - h)) / (2 * h)
    for variable, later, earlier in (
        (x, clip(u + h, -w, w), clip(u - h, -w, w)),
        (s, clip(u, -w - h, w + h), clip(u, h - w, w - h)),
    ):
        assert sympy.diff(clip(x, -s, s), variable).subs(at) == (later - earlier) / (2 * h)
    q = sympy.Rational(2, 5)
    slope = (quantise(u, q + h) - quantise(u, q - h)) / (2 * h)
    assert sympy.diff(quantise(x, s), s).subs({x: u, s: q}) == slope


def test_latex() -> None:
    assert sympy.latex(sign_of(v)) == r"\operatorname{sign}\left(v\right)"
    assert sympy.latex(sign_of(v) ** 2) == r"\operatorname{sign}^{2}\left(v\right)"
    assert sympy.latex(deadzone(x, s)) == r"\operatorname{dz}_{S}\left(x\right)"
    assert sympy.latex(clip(x, -s, s)) == r"\operatorname{clip}_{- S}^{S}\left(x\right)"
    assert sympy.latex(clip(x, -s, s) ** 2) == r"\left(\operatorname{clip}_{- S}^{S}\left(x\right)\right)^{2}"
    assert sympy.latex(quantise(x, s)) == r"\operatorname{quant}_{S}\left(x\right)"
    assert sympy.latex(deadzone(x, s) ** 2) == r"\left(\operatorname{dz}_{S}\left(x\right)\right)^{2}"


def test_smoothness() -> None:
    assert is_smooth(k * sympy.sin(x))
    own = (sign_of(v), step(x), deadzone(x, s), outside(x, s), clip(x, -s, s), quantise(x, s))
    for kinked in (*own, sympy.Abs(x), sympy.sign(x), sympy.Max(x, v)):
        assert not is_smooth(k * kinked + x)


def test_redundant_gaps_are_absorbed() -> None:
    force = k * deadzone(x, s) + d * v * outside(x, s)
    assert absorb(outside(x, s) * force) == force
    assert absorb(outside(x, s) ** 2 * v) == v * outside(x, s)


def test_gaps_that_matter_are_kept() -> None:
    for product in (k * outside(x, s) + deadzone(x, s), outside(x, s) * deadzone(v, s), outside(x, s) * x):
        assert absorb(product) == product
