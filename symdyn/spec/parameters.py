"""The parameters of a robot: those of [parameters], and one for each literal in the tree."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from fractions import Fraction

from symdyn.base.latex_check import is_safe_latex
from symdyn.base.names import LONGEST_NAME, collisions, identifier_problem, latex_of, with_subscripts
from symdyn.base.number_text import parse_number, to_float
from symdyn.base.units import UnitError, UnitRef, describe, parse_quantity, parse_unit
from symdyn.base.wording import quoted
from symdyn.spec.findings import Findings
from symdyn.spec.records import Parameter
from symdyn.spec.schema import ParameterEntry, Scalar
from symdyn.spec.toml_positions import KeyPath

_PLAIN = parse_unit("1")


class Parameters:
    """Grows while a file is read; names stay unique, in the order in which they were met."""

    def __init__(self, entries: Mapping[str, ParameterEntry], findings: Findings) -> None:
        self._entries = entries
        self._by_name: dict[str, Parameter] = {}
        self.values: dict[str, float | None] = {}
        self._unreadable: set[str] = set()
        self._taken: set[str] = set()  # case-folded
        self._repeats: Counter[str] = Counter()
        names = list(entries)
        for later, first in collisions(names):
            there = findings.where(("parameters", names[first]), key=True)
            findings.error(
                ("parameters", names[later]),
                "SD103",
                f"{quoted(names[later])} and {quoted(names[first])} ({there}) differ only by upper and lower case",
                key=True,
            )
        for name, entry in entries.items():
            self._taken.add(name.casefold())
            parameter = _read_entry(name, entry, findings)
            if parameter is None:
                self._unreadable.add(name)
            else:
                self._add(parameter)

    def add_literal(
        self, name: str, value: float, unit: str, latex: str, meaning: str, path: KeyPath, findings: Findings
    ) -> str:
        """Give a literal of the tree a name of its own; returns it (numbered where it is taken already)."""
        candidate = stem = name[:LONGEST_NAME]
        while candidate.casefold() in self._taken:
            self._repeats[stem] += 1
            candidate = f"{stem[: LONGEST_NAME - 8]}_{self._repeats[stem] + 1}"
        if self._repeats[stem]:  # two that look alike in an equation would be taken for one
            latex = with_subscripts(latex, [str(self._repeats[stem] + 1)])
        self._taken.add(candidate.casefold())
        self._add(Parameter(candidate, value, unit, latex, meaning, findings.where(path)))
        return candidate

    def is_unreadable(self, name: str) -> bool:
        """Whether the name is defined, by an entry that is wrong (and told so)."""
        return name in self._unreadable

    def __contains__(self, name: str) -> bool:
        return name in self.written

    @property
    def written(self) -> Mapping[str, object]:
        """The names in [parameters]: what a number of the file may refer to."""
        return self._entries

    @property
    def every(self) -> tuple[Parameter, ...]:
        return tuple(self._by_name.values())

    def unit(self, name: str) -> UnitRef:
        return parse_unit(self._by_name[name].unit)

    def _add(self, parameter: Parameter) -> None:
        self._by_name[parameter.name] = parameter
        self.values[parameter.name] = parameter.value


def _read_entry(name: str, entry: ParameterEntry, findings: Findings) -> Parameter | None:
    path: KeyPath = ("parameters", name)
    problem = identifier_problem(name)
    if problem is not None:
        findings.error(path, problem.code, problem.message, problem.hint, key=True)
    if findings.is_blamed_within(path):
        return None
    if entry.latex is not None and not is_safe_latex(entry.latex):
        findings.error(
            (*path, "latex"),
            "SD108",
            f"LaTeX {quoted(entry.latex)} is not allowed",
            r"letters, digits, Greek, accents, \mathrm, sub- and superscripts: m_{2}",
        )
    latex = entry.latex if entry.latex is not None else latex_of(name)
    try:
        value, unit = _value_and_unit(entry)
    except UnitError as error:
        findings.error(_blamed_key(path, entry), error.code, error.message, error.hint)
        return None
    if value is not None and to_float(value) in (float("inf"), float("-inf")):
        findings.error(_blamed_key(path, entry), "SD201", "a number must be finite")
        return None
    in_si = None if value is None else to_float(value)
    return Parameter(name, in_si, unit.si, latex, entry.meaning, findings.where(path, key=True))


def _value_and_unit(entry: ParameterEntry) -> tuple[Fraction | None, UnitRef]:
    """Value in SI (None: left free) and unit."""
    if entry.free is not None:
        if entry.value is not None or entry.unit is not None:
            raise UnitError("SD202", "`free` stands alone: its text is the unit", 'write { free = "kg" }')
        return None, parse_unit(entry.free)
    if entry.value is None:
        if entry.unit is None:
            raise UnitError("SD107", "a parameter needs a value or a unit", 'write "12 kg", or { free = "kg" }')
        return None, parse_unit(entry.unit)
    number, own = _number_and_unit(entry.value)
    stated = parse_unit(entry.unit) if entry.unit is not None else None
    if own is None:
        unit = stated or _PLAIN
        return number * unit.factor, unit
    if stated is not None and stated.dimension != own.dimension:
        raise UnitError("SD221", f"dimension {describe(own)}, but its unit is {describe(stated)}")
    return number * own.factor, own


def _number_and_unit(value: Scalar) -> tuple[Fraction, UnitRef | None]:
    if not isinstance(value, str):
        return Fraction(str(value)), None  # 1.2 means twelve tenths, not the float below it
    try:
        return parse_number(value.strip()), None
    except ValueError:
        return parse_quantity(value)


def _blamed_key(path: KeyPath, entry: ParameterEntry) -> KeyPath:
    """Where to point: at the value, else at the unit."""
    key = next((key for key in ("value", "free", "unit") if getattr(entry, key) is not None), "value")
    return (*path, key)
