"""Reads one number of a robot: plain (SI), with a unit, or a monomial over [parameters]; checks its dimension."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

from symdyn.base.names import with_subscripts
from symdyn.base.number_text import to_float
from symdyn.base.units import (
    UnitError,
    describe,
    describe_dimension,
    parse_quantity,
    parse_unit,
    product,
    require_dimension,
)
from symdyn.base.wording import closest, did_you_mean, quoted
from symdyn.spec.findings import Findings
from symdyn.spec.monomials import parse_monomial, value_of
from symdyn.spec.parameters import Parameters
from symdyn.spec.records import ZERO, Monomial
from symdyn.spec.schema import Scalar
from symdyn.spec.toml_positions import KeyPath


@dataclass(frozen=True, slots=True)
class Slot:
    """Where a number stands and what it is: key path, owner (joint, part), key, unit, symbol, meaning."""

    path: KeyPath
    owner: tuple[str, ...]
    key: str
    unit: str
    symbol: str  # LaTeX, without the owner
    meaning: str

    @property
    def automatic_name(self) -> str:
        return "_".join((*self.owner, self.key))


class NumberReader:
    """Turns scalars of the file into monomials; literals become parameters."""

    def __init__(self, parameters: Parameters, findings: Findings) -> None:
        self.parameters = parameters
        self.findings = findings

    def read(self, value: Scalar, slot: Slot, *, keep_zero: bool = False) -> Monomial:
        """A monomial of the slot's dimension; ZERO after an error, which is added to the findings.

        A literal zero is structural (no parameter) unless ``keep_zero``.
        """
        quantity = self._finite(value, slot)
        if isinstance(quantity, Monomial):
            return quantity
        if quantity == 0 and not keep_zero:
            return ZERO
        return self.literal(quantity, slot)

    def read_plain(self, value: Scalar, slot: Slot) -> Monomial:
        """As ``read``, for an angle of the geometry or a count: a literal stays a plain number in SI units."""
        quantity = self._finite(value, slot)
        if isinstance(quantity, Monomial):
            return quantity
        return Monomial(Fraction(int(quantity)) if quantity == int(quantity) else quantity)

    def read_in_one_of(self, value: Scalar, slot: Slot, units: tuple[str, ...]) -> tuple[Monomial, str]:
        """As ``read``, where the value's own dimension decides between units; the one chosen comes second."""
        for unit in units if isinstance(value, str) else ():
            try:
                self._resolved(value, unit)
            except UnitError:
                continue
            return self.read(value, _with_unit(slot, unit)), unit
        if isinstance(value, str):
            return self.read(value, slot), slot.unit  # tells what is wrong
        wanted = " or ".join(f'"{value} {unit}"' for unit in units)
        self.findings.error(slot.path, "SD221", "a plain number does not tell its unit", f"write {wanted}")
        return ZERO, slot.unit

    def literal(self, value: float, slot: Slot) -> Monomial:
        """A parameter of its own for a number that stands in the tree."""
        latex = with_subscripts(slot.symbol, slot.owner) if slot.owner else slot.symbol
        name = self.parameters.add_literal(
            slot.automatic_name, value + 0.0, slot.unit, latex, slot.meaning, slot.path, self.findings
        )
        return Monomial(Fraction(1), ((name, 1),))

    def value(self, monomial: Monomial) -> float | None:
        return value_of(monomial, self.parameters.values)

    def _finite(self, value: Scalar, slot: Slot) -> float | Monomial:
        """The resolved number where it is one and finite; else ZERO, and an error."""
        try:
            quantity = self._resolved(value, slot.unit)
        except UnitError as error:
            self.findings.error(slot.path, error.code, error.message, error.hint)
            return ZERO
        known = self.value(quantity) if isinstance(quantity, Monomial) else quantity
        if known is None or math.isfinite(known):
            return quantity
        self.findings.error(slot.path, "SD201", "a number must be finite")
        return ZERO

    def _resolved(self, value: Scalar, unit: str) -> float | Monomial:
        """The SI value of a literal, or a monomial with factors. UnitError where it is neither.

        ``"2 m"`` may be two metres or twice a parameter ``m``: the expected dimension decides.
        """
        if not isinstance(value, str):
            return float(value)
        monomial = parse_monomial(value)
        if monomial is not None and any(self.parameters.is_unreadable(name) for name, _ in monomial.factors):
            return ZERO  # told at its definition
        as_quantity = _quantity_or_error(value, unit)
        as_monomial = self._monomial_or_error(monomial, value, unit)
        if not isinstance(as_quantity, UnitError):
            if isinstance(as_monomial, Monomial):
                raise UnitError(
                    "SD222",
                    f"{quoted(value)} may be a quantity or a multiple of a parameter",
                    f"write {quoted(value.strip().replace(' ', ' * ', 1))} for the parameter, or rename it",
                )
            return as_quantity
        if not isinstance(as_monomial, UnitError):
            return as_monomial
        raise as_quantity if self._blames_quantity(as_quantity, monomial, value) else as_monomial

    def _monomial_or_error(self, monomial: Monomial | None, text: str, unit: str) -> float | Monomial | UnitError:
        if monomial is None:
            return UnitError("SD222", "")
        unknown = [name for name, _ in monomial.factors if name not in self.parameters]
        if unknown:
            hint = did_you_mean(unknown[0], self.parameters.written, "parameters")
            return UnitError(
                "SD104", f"no parameter {quoted(unknown[0])}", hint or f'define it: [parameters] {unknown[0]} = "..."'
            )
        target = parse_unit(unit)
        found = product(*((self.parameters.unit(name).dimension, power) for name, power in monomial.factors))
        if found != target.dimension:
            hint = (
                f'give it a unit: "{text.strip()} {unit}"'
                if not monomial.factors
                else "; ".join(self._told_unit(name) for name, _ in monomial.factors)
            )
            return UnitError("SD221", f"dimension {describe_dimension(found)}, expected {describe(target)}", hint)
        if "rad" in target.si and any("Hz" in self.parameters.unit(name).si for name, _ in monomial.factors):
            return UnitError("SD221", f"hertz counts cycles, expected {describe(target)}", "write rad/s, deg/s or rpm")
        if not monomial.factors:
            return to_float(Fraction(monomial.coefficient))
        return ZERO if monomial.is_zero else monomial

    def _told_unit(self, name: str) -> str:
        unit = self.parameters.unit(name).si
        return f"{name} has no unit" if unit == "1" else f"{name} is in {unit}"

    def _blames_quantity(self, error: UnitError, monomial: Monomial | None, text: str) -> bool:
        """Which of two failed readings the writer meant."""
        if monomial is None or error.code == "SD221":
            return True
        names = [name for name, _ in monomial.factors]
        is_about_parameters = any(
            name in self.parameters or closest(name, self.parameters.written) is not None for name in names
        )
        starts_with_number = text.lstrip(" +-")[:1].isdigit()
        return starts_with_number and bool(names) and not is_about_parameters


def _quantity_or_error(text: str, unit: str) -> float | UnitError:
    try:
        number, own = parse_quantity(text)
        require_dimension(own, unit)
    except UnitError as error:
        return error
    return to_float(number * own.factor)


def _with_unit(slot: Slot, unit: str) -> Slot:
    return Slot(slot.path, slot.owner, slot.key, unit, slot.symbol, slot.meaning)
