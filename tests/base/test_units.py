from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.base.units import (
    UnitError,
    describe_dimension,
    parse_quantity,
    parse_unit,
    product,
    quantity_in_si,
    same_dimension,
    si_factor,
)

QUANTITIES = [
    ("12 kg", "kg", 12.0),
    ("34e-6 kg m^2", "kg m^2", 34e-6),
    ("1200e-6 N m s/rad", "N m s/rad", 1200e-6),
    ("0.088 N m/A", "N m/A", 0.088),
    ("0.05 Nm/A", "N m/A", 0.05),  # pint alone reads Nm as 1000/m
    ("3 Nm", "N m", 3.0),
    ("250 mNm", "N m", 0.25),
    ("250 mN m", "N m", 0.25),
    ("250 mN·m", "N m", 0.25),
    ("250 mN*m", "N m", 0.25),
    ("0.1 mNms/rad", "N m s/rad", 1e-4),
    ("1.6 Ohm", "Ohm", 1.6),
    ("1.6 kΩ", "Ohm", 1600.0),
    ("87 uH", "H", 87e-6),
    ("87 µH", "H", 87e-6),
    ("90 deg", "rad", math.pi / 2),
    ("90 °", "rad", math.pi / 2),
    ("1 rev", "rad", 2 * math.pi),
    ("60 rpm", "rad/s", 2 * math.pi),
    ("3 rev/min", "rad/s", math.pi / 10),
    ("5 Hz", "1/s", 5.0),
    ("9.81 m/s^2", "m/s^2", 9.81),
    ("9.81 m s^-2", "m/s^2", 9.81),
    ("9.81 m/s²", "m/s^2", 9.81),
    ("200 g cm^2", "kg m^2", 2e-5),
    ("1/12 m", "m", 1 / 12),
    ("-1/2 m", "m", -0.5),
    ("+.5 mm", "m", 0.0005),
    ("5. mm", "m", 0.005),
    ("2 1/s", "1/s", 2.0),
    ("1.44 N m", "N m/rad", 1.44),  # the radian is dimensionless
    ("0.029 N m/A", "V s/rad", 0.029),
    ("4 J", "N m", 4.0),
    ("2 h", "s", 7200.0),
    ("  7   N/m/s ", "N/m/s", 7.0),
]


@pytest.mark.parametrize(("text", "unit", "value"), QUANTITIES)
def test_quantity_is_the_float_nearest_to_what_is_written(text: str, unit: str, value: float) -> None:
    assert quantity_in_si(text, unit) == value


@pytest.mark.parametrize(
    "text",
    ["3,5 mm", "5 furlong", "10**10**8", "heavy", "", "5", "kg", "5mm", "5 kg kg2", "5 m^", "5 m^99", "1/0 m", "5 //m",
     "5 m/", "5 1/12 m", "0x10 m", "1_000 m", "nan kg", "inf kg", "5 mmin", "5 J/kg K", "5 __import__('os')",
     "5 m; m", "5 M", "5 m\x00", "5 " + "m " * 5000, "9" * 5000 + " m", "1e99999 m", "５ m", "5 ｍ", "5 m\n5 m^2 x"],
)  # fmt: skip
def test_what_is_no_quantity_is_refused(text: str) -> None:
    with pytest.raises(UnitError) as caught:
        quantity_in_si(text, "m")
    assert caught.value.code == "SD222"


def test_wrong_dimension_names_both() -> None:
    with pytest.raises(UnitError, match=r"dimension torque \(Nm\), expected length \(m\)") as caught:
        quantity_in_si("5 Nm", "m")
    assert caught.value.code == "SD221"


@pytest.mark.parametrize(("text", "unit"), [("10 Hz", "rad/s"), ("10 N m/Hz", "N m s/rad")])
def test_cycles_do_not_pass_for_radians(text: str, unit: str) -> None:
    with pytest.raises(UnitError, match="counts cycles"):
        quantity_in_si(text, unit)


def test_hints() -> None:
    for text, hint in [("3,5 mm", "decimal point"), ("5mm", "space"), ("5 furlong", "units:"), ("5 kgs", "`kg`")]:
        with pytest.raises(UnitError) as caught:
            quantity_in_si(text, "m")
        assert hint in caught.value.hint


def test_too_large_is_infinite_not_an_overflow() -> None:
    assert quantity_in_si("1e999 kg", "kg") == math.inf
    assert quantity_in_si("-1e999 kg", "kg") == -math.inf
    assert si_factor("Gm^9 Gm^9 Gm^9 Gm^9", "m^9 m^9 m^9 m^9") == math.inf


def test_number_is_exact_and_unit_is_told_in_si() -> None:
    number, unit = parse_quantity("0.1 mNm/A")
    assert number == Fraction(1, 10)
    assert (unit.text, unit.si, unit.factor) == ("mNm/A", "N m/A", Fraction(1, 1000))
    assert [parse_unit(text).si for text in ("g cm^2", "rpm", "deg", "uH", "m m", "1", "1/s", "rad/rad")] == [
        "kg m^2", "rad/s", "rad", "H", "m^2", "1", "1/s", "1",
    ]  # fmt: skip


def test_factor() -> None:
    assert si_factor("mm", "m") == 0.001
    with pytest.raises(UnitError, match="expected time"):
        si_factor("mm", "s")


def test_same_dimension() -> None:
    assert same_dimension("N m/A", "V s/rad")
    assert same_dimension("rpm", "1/s")
    assert not same_dimension("N m", "N")


def test_dimension_of_a_product_has_a_name() -> None:
    mass, length = parse_unit("kg").dimension, parse_unit("m").dimension
    assert describe_dimension(product((mass, 1), (length, 2))) == "moment of inertia (kg m^2)"
    assert describe_dimension(product((mass, 7))) == "mass^7"
    assert describe_dimension(product((mass, 1), (mass, -1))) == "plain number (1)"


@settings(deadline=None)
@given(st.text(max_size=40))
def test_any_text_is_a_quantity_or_a_unit_error(text: str) -> None:
    for candidate in (text, "5 " + text):
        try:
            number, unit = parse_quantity(candidate)
        except UnitError:
            continue
        assert parse_unit(unit.si).dimension == unit.dimension
        assert isinstance(number, Fraction)


@settings(deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_float_survives(value: float) -> None:
    assert quantity_in_si(f"{value!r} kg", "kg") == value
