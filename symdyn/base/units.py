"""Values with units: a whitelist of unit names, their factor to SI and their dimension.

The text is checked here, token by token; pint only tells factor and dimension of a whitelisted unit.
(Left to parse by itself it reads "3 Nm" as 3000 m/kg and "3,5 mm" as 35 mm.)
Factors are exact fractions, so a value in SI is the float nearest to what was written.
The radian is dimensionless.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING

from symdyn.base.number_text import UNSIGNED, parse_number, to_float
from symdyn.base.wording import closest, listed, quoted

if TYPE_CHECKING:
    import pint

Dimension = tuple[tuple[str, int], ...]  # ((base unit, power), ...), sorted; () for a plain number


class UnitError(ValueError):
    """A text that is no quantity (code SD222), or one of the wrong dimension (SD221)."""

    def __init__(self, code: str, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.hint = hint


@dataclass(frozen=True, slots=True)
class UnitRef:
    """A unit: as written, in SI base and derived units, factor to SI, dimension."""

    text: str
    si: str
    factor: Fraction
    dimension: Dimension
    counts_cycles: bool = False  # hertz: must not pass for rad/s


@dataclass(frozen=True, slots=True)
class _Token:
    pint_name: str
    si: tuple[tuple[str, int], ...]
    prefixable: bool = True


_TOKENS: Mapping[str, _Token] = MappingProxyType(
    {
        "m": _Token("meter", (("m", 1),)),
        "g": _Token("gram", (("kg", 1),)),
        "s": _Token("second", (("s", 1),)),
        "A": _Token("ampere", (("A", 1),)),
        "K": _Token("kelvin", (("K", 1),)),
        "N": _Token("newton", (("N", 1),)),
        "J": _Token("joule", (("J", 1),)),
        "W": _Token("watt", (("W", 1),)),
        "Pa": _Token("pascal", (("Pa", 1),)),
        "V": _Token("volt", (("V", 1),)),
        "Ohm": _Token("ohm", (("Ohm", 1),)),
        "H": _Token("henry", (("H", 1),)),
        "F": _Token("farad", (("F", 1),)),
        "Hz": _Token("hertz", (("Hz", 1),)),
        "rad": _Token("radian", (("rad", 1),)),
        "Nm": _Token("newton_meter", (("N", 1), ("m", 1))),
        "Nms": _Token("newton_meter_second", (("N", 1), ("m", 1), ("s", 1))),
        "deg": _Token("degree", (("rad", 1),), prefixable=False),
        "rev": _Token("revolution", (("rad", 1),), prefixable=False),
        "rpm": _Token("rpm", (("rad", 1), ("s", -1)), prefixable=False),
        "min": _Token("minute", (("s", 1),), prefixable=False),
        "h": _Token("hour", (("s", 1),), prefixable=False),
    }
)
_PREFIXES: Mapping[str, int] = MappingProxyType(
    {"G": 9, "M": 6, "k": 3, "d": -1, "c": -2, "m": -3, "u": -6, "n": -9, "p": -12}
)
_SPELLINGS = str.maketrans(
    {"\u00b5": "u", "\u03bc": "u", "\u2126": "Ohm", "\u03a9": "Ohm", "\u00b0": "deg", "\u00b2": "^2", "\u00b3": "^3"}
)
_COMMON_MULTIPLES = ("kg", "mm", "cm", "ms", "mNm", "mH", "uH", "kOhm", "mrad")
_LONGEST = 100

_NAMES: Mapping[str, str] = MappingProxyType(
    {
        "1": "plain number",
        "rad": "angle",
        "m": "length",
        "kg": "mass",
        "s": "time",
        "rad/s": "angular velocity",
        "m/s": "velocity",
        "rad/s^2": "angular acceleration",
        "m/s^2": "acceleration",
        "N": "force",
        "N m": "torque",
        "kg m^2": "moment of inertia",
        "N m/rad": "rotational stiffness",
        "N/m": "stiffness",
        "N m s/rad": "rotational damping",
        "N s/m": "damping",
        "A": "current",
        "V": "voltage",
        "Ohm": "resistance",
        "H": "inductance",
        "F": "capacitance",
        "N m/A": "torque constant",
        "N/A": "force constant",
        "V s/rad": "back-EMF constant",
        "V s/m": "back-EMF constant",
        "N m/V": "torque per voltage",
        "N/V": "force per voltage",
        "W": "power",
        "Pa": "pressure",
        "K": "temperature",
        "1/m": "inverse length",
    }
)

_FACTOR = r"(?:1|[A-Za-z]+(?:\^-?\d)?)"
_UNIT = re.compile(rf"{_FACTOR}(?:(?:\s*[*·/]\s*|\s+){_FACTOR})*", re.ASCII)
_PIECE = re.compile(r"(?P<separator>\s*[*·/]\s*|\s+|^)(?P<name>1|[A-Za-z]+)(?:\^(?P<power>-?\d))?", re.ASCII)
_QUANTITY = re.compile(rf"(?P<number>[+-]?\s*{UNSIGNED})\s+(?P<unit>\S.*)", re.ASCII)


def parse_quantity(text: str) -> tuple[Fraction, UnitRef]:
    """Read ``"number unit"``: the number as written, and its unit. UnitError SD222 for anything else."""
    text = text.strip()
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST else None
    if match is None:
        raise UnitError("SD222", f'{quoted(text)} is not "number unit"', _quantity_hint(text))
    try:
        number = parse_number("".join(match["number"].split()))
    except ValueError as error:
        raise UnitError("SD222", f"{quoted(text)} is {error}") from None
    return number, parse_unit(match["unit"])


def quantity_in_si(text: str, expected: str) -> float:
    """The value in SI of ``"number unit"``, whose dimension must be that of the unit ``expected``.

    May be infinite: ``"1e999 kg"``.
    """
    number, unit = parse_quantity(text)
    require_dimension(unit, expected)
    return to_float(number * unit.factor)


def si_factor(text: str, expected: str) -> float:
    """The factor to SI of a unit (``"mm"``: 0.001), whose dimension must be that of ``expected``."""
    unit = parse_unit(text)
    require_dimension(unit, expected)
    return to_float(unit.factor)


def same_dimension(first: str, second: str) -> bool:
    """Whether two units have one dimension (the radian counts as 1)."""
    return parse_unit(first).dimension == parse_unit(second).dimension


def require_dimension(unit: UnitRef, expected: str) -> None:
    """UnitError SD221 unless the unit has the dimension of ``expected``."""
    target = parse_unit(expected)
    if unit.dimension != target.dimension:
        raise UnitError("SD221", f"dimension {describe(unit)}, expected {describe(target)}")
    if unit.counts_cycles and "rad" in target.si:
        raise UnitError("SD221", f"{unit.text} counts cycles, expected {describe(target)}", "write rad/s, deg/s or rpm")


def describe(unit: UnitRef) -> str:
    """``torque (N m)``: the name of a unit's dimension, and the unit."""
    name = _NAMES.get(unit.si) or _dimension_names().get(unit.dimension, "")
    return f"{name} ({unit.text})" if name else unit.text


def describe_dimension(dimension: Dimension) -> str:
    """``torque (N m)``, or the base units where the dimension has no name."""
    for text, name in _NAMES.items():
        if parse_unit(text).dimension == dimension:
            return f"{name} ({text})"
    return _joined(dimension)


def product(*factors: tuple[Dimension, int]) -> Dimension:
    """The dimension of a product of powers."""
    powers: Counter[str] = Counter()
    for dimension, power in factors:
        for base, exponent in dimension:
            powers[base] += exponent * power
    return tuple(sorted((base, exponent) for base, exponent in powers.items() if exponent))


@lru_cache(maxsize=1024)
def parse_unit(text: str) -> UnitRef:
    """Read a unit such as ``"kg m^2"``, ``"N m s/rad"`` or ``"mNm/A"``; UnitError SD222 where it is none.

    Powers are integers; units are multiplied by a space, ``*`` or ``·``, and each ``/`` divides by the one
    unit that follows it. A product after a slash is ambiguous ("J/kg K") and refused.
    """
    spelled = text.strip().translate(_SPELLINGS)
    if len(spelled) > _LONGEST or _UNIT.fullmatch(spelled) is None:
        raise UnitError("SD222", f"{quoted(text)} is not a unit", _unit_hint())
    factor = Fraction(1)
    si: list[tuple[str, int]] = []
    dimensions: list[tuple[Dimension, int]] = []
    counts_cycles = divided = False
    for piece in _PIECE.finditer(spelled):
        divides = "/" in piece["separator"]
        if divided and not divides:
            raise UnitError("SD222", f"unit {quoted(text)} is ambiguous", "write a slash before each divisor: J/kg/K")
        divided = divided or divides
        if piece["name"] == "1":
            continue
        power = int(piece["power"] or 1) * (-1 if divides else 1)
        exponent, name = _split_prefix(piece["name"], text)
        token = _TOKENS[name]
        unit_factor, dimension = _pint_unit(token.pint_name)
        factor *= (Fraction(10) ** exponent * unit_factor) ** power
        dimensions.append((dimension, power))
        si.extend((symbol, own * power) for symbol, own in token.si)
        counts_cycles = counts_cycles or name == "Hz"
    return UnitRef(text.strip(), _joined(si), factor, product(*dimensions), counts_cycles)


def _split_prefix(name: str, text: str) -> tuple[int, str]:
    if name in _TOKENS:
        return 0, name
    prefix, rest = name[:1], name[1:]
    if prefix in _PREFIXES and rest in _TOKENS and _TOKENS[rest].prefixable:
        return _PREFIXES[prefix], rest
    where = "" if name == text.strip() else f" in {quoted(text)}"
    meant = closest(name, (*_TOKENS, *_COMMON_MULTIPLES))
    raise UnitError(
        "SD222", f"{quoted(name)}{where} is not a unit", f"did you mean {quoted(meant)}?" if meant else _unit_hint()
    )


def _joined(powers: list[tuple[str, int]] | Dimension) -> str:
    """``N m s/rad`` from symbols and powers, equal symbols merged, in order of appearance."""
    total: dict[str, int] = {}
    for symbol, power in powers:
        total[symbol] = total.get(symbol, 0) + power
    above = [_power(symbol, power) for symbol, power in total.items() if power > 0]
    below = ["/" + _power(symbol, -power) for symbol, power in total.items() if power < 0]
    return (" ".join(above) or "1") + "".join(below)


def _power(symbol: str, power: int) -> str:
    return symbol if power == 1 else f"{symbol}^{power}"


def _unit_hint() -> str:
    return f'units: {listed(_TOKENS, 99)}, with SI prefixes; write them like "N m s/rad"'


def _quantity_hint(text: str) -> str:
    if re.search(r"\d,\d", text):
        return 'write a decimal point: "3.5 mm"'
    if re.fullmatch(rf"\s*[+-]?{UNSIGNED}[A-Za-z].*", text):
        return 'write a space between number and unit: "5 mm"'
    return 'write a number, a space and a unit, such as "12 kg" or "0.05 N m/A"'


@cache
def _registry() -> pint.UnitRegistry[Fraction]:
    import pint  # a third of a second: only where a unit is met

    registry: pint.UnitRegistry[Fraction] = pint.UnitRegistry(non_int_type=Fraction)
    return registry


@cache
def _pint_unit(name: str) -> tuple[Fraction, Dimension]:
    """Exact factor to SI base units and dimension of a unit of the whitelist."""
    registry = _registry()
    unit = registry.Unit(name.replace("_", " * "))
    factor, _ = registry.get_base_units(unit)
    powers = ((base.strip("[]"), int(Fraction(str(power)))) for base, power in unit.dimensionality.items())
    return Fraction(str(factor)), tuple(sorted(powers))


@cache
def _dimension_names() -> Mapping[Dimension, str]:
    return {parse_unit(text).dimension: name for text, name in reversed(tuple(_NAMES.items()))}
