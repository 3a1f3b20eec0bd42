from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.spec.monomials import parse_monomial, value_of
from symdyn.spec.records import Monomial


@pytest.mark.parametrize(
    ("text", "coefficient", "factors"),
    [
        ("m_2", Fraction(1), (("m_2", 1),)),
        ("-1/2 l_2", Fraction(-1, 2), (("l_2", 1),)),
        ("1/12 m l^2", Fraction(1, 12), (("m", 1), ("l", 2))),
        ("-g", Fraction(-1), (("g", 1),)),
        ("- g", Fraction(-1), (("g", 1),)),
        ("0.5 * l * m", Fraction(1, 2), (("l", 1), ("m", 1))),
        ("1e3 l·m^-2", Fraction(1000), (("l", 1), ("m", -2))),
        ("m l^2/12", Fraction(1, 12), (("m", 1), ("l", 2))),
        ("m/l/k", Fraction(1), (("m", 1), ("l", -1), ("k", -1))),
        ("m l m^-1", Fraction(1), (("l", 1),)),
        ("121/3", Fraction(121, 3), ()),
    ],
)
def test_monomial(text: str, coefficient: Fraction, factors: tuple[tuple[str, int], ...]) -> None:
    assert parse_monomial(text) == Monomial(coefficient, factors)


@pytest.mark.parametrize(
    "text",
    ["", " ", "-", "2l", "l 2", "m / l k", "10**10**8", "3,5 mm", "m-l", "m+l", "m.x", "m()", "__import__", "1/0 m",
     "m/0", "1/2/3 m", "l^22", "l^", "m" * 300, "l l^", "--g", "m\x00", "ｍ"],
)  # fmt: skip
def test_not_a_monomial(text: str) -> None:
    assert parse_monomial(text) is None


def test_value() -> None:
    values = {"m": 3.0, "l": 2.0, "free": None, "zero": 0.0, "huge": 1e300}
    assert value_of(Monomial(Fraction(1, 12), (("m", 1), ("l", 2))), values) == 1.0
    assert value_of(Monomial(Fraction(1), (("m", 1), ("free", 1))), values) is None
    assert value_of(Monomial(Fraction(1), (("huge", 2),)), values) == math.inf
    assert math.isnan(value_of(Monomial(Fraction(1), (("zero", -1),)), values) or 0.0)


@settings(deadline=None)
@given(st.text(alphabet=st.sampled_from("ml_^-/*12 .e+·"), max_size=30))
def test_any_text_is_judged(text: str) -> None:
    monomial = parse_monomial(text)
    assert monomial is None or all(power for _, power in monomial.factors)
