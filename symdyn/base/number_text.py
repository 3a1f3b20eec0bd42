"""Numbers written as text, read exactly: ``"36e-6"`` and ``"1/12"`` become fractions, never floats."""

from __future__ import annotations

import re
from fractions import Fraction

DECIMAL = r"(?:\d{1,40}(?:\.\d{0,40})?|\.\d{1,40})(?:[eE][+-]?\d{1,3})?"
SIMPLE_FRACTION = r"\d{1,20}/\d{1,20}"
UNSIGNED = rf"(?:{SIMPLE_FRACTION}|{DECIMAL})"

_NUMBER = re.compile(rf"([+-]?)({UNSIGNED})", re.ASCII)


def parse_number(text: str) -> Fraction:
    """The exact value of a decimal, scientific or simple fraction text; ValueError for anything else."""
    match = _NUMBER.fullmatch(text)
    if match is None:
        raise ValueError("not a number")
    try:
        magnitude = Fraction(match[2])
    except ZeroDivisionError:
        raise ValueError("a fraction over zero") from None
    return -magnitude if match[1] == "-" else magnitude


def is_number(text: str) -> bool:
    """Whether ``parse_number`` reads the text."""
    try:
        parse_number(text)
    except ValueError:
        return False
    return True


def to_float(value: Fraction) -> float:
    """The nearest float, infinite where it does not fit."""
    try:
        return float(value)
    except OverflowError:
        return float("inf") if value > 0 else float("-inf")
