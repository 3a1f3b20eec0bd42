"""Monomials as people write them: ``"-1/2 l"``, ``"1/12 m l^2"``. Read by a grammar, never evaluated as code."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from fractions import Fraction

from symdyn.base.number_text import UNSIGNED, parse_number, to_float
from symdyn.spec.records import Monomial

_SIGN = re.compile(r"([+-]?)\s*")
_FACTOR = re.compile(
    rf"(?:(?P<number>{UNSIGNED})|(?P<name>[A-Za-z][A-Za-z0-9_]*)(?:\^(?P<power>-?\d))?)(?![\w.^])", re.ASCII
)
_SEPARATOR = re.compile(r"\s*[*·/]\s*|\s+")
_LONGEST = 200


def parse_monomial(text: str) -> Monomial | None:
    """Read ``[sign] [number] name^k name ... / name / number``; None where the text is nothing like it.

    A name is a parameter's, an integer of one digit is its power; factors are separated by spaces or ``*``.
    """
    text = text.strip()
    if not 0 < len(text) <= _LONGEST:
        return None
    sign = _SIGN.match(text)
    at = sign.end() if sign else 0
    coefficient = Fraction(-1 if text[0] == "-" else 1)
    powers: dict[str, int] = {}
    is_first, divides = True, False
    while True:
        factor = _FACTOR.match(text, at)
        if factor is None or (factor["number"] and not (is_first or divides)):
            return None
        if factor["number"]:
            try:
                number = parse_number(factor["number"])
                coefficient = coefficient / number if divides else coefficient * number
            except (ValueError, ZeroDivisionError):
                return None
        else:
            power = int(factor["power"] or 1)
            powers[factor["name"]] = powers.get(factor["name"], 0) + (-power if divides else power)
        at, is_first = factor.end(), False
        if at == len(text):
            return Monomial(coefficient, tuple((name, power) for name, power in powers.items() if power))
        separator = _SEPARATOR.match(text, at)
        if separator is None or (divides and "/" not in separator[0]):
            return None  # "a / b c" could mean either
        at, divides = separator.end(), "/" in separator[0]


def parameter_of(monomial: Monomial) -> str | None:
    """The parameter that it is, and nothing else; None where there is more to it, or no parameter."""
    return monomial.factors[0][0] if monomial.coefficient == 1 and [k for _, k in monomial.factors] == [1] else None


def value_of(monomial: Monomial, values: Mapping[str, float | None]) -> float | None:
    """The number that a monomial stands for; None where a parameter is free; infinite or NaN where it overflows."""
    coefficient = monomial.coefficient
    result = to_float(coefficient) if isinstance(coefficient, Fraction) else coefficient
    for name, power in monomial.factors:
        value = values[name]
        if value is None:
            return None
        try:
            result *= value**power
        except OverflowError:
            return math.inf
        except ZeroDivisionError:
            return math.nan
    return result
