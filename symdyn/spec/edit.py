"""Edits a robot's TOML text, comments kept: a diagnosis adds the effect it found, a fit sets parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import AoT, Array, InlineTable, Item

from symdyn.base.errors import InputError, Problem, Where
from symdyn.base.names import identifier_problem
from symdyn.base.number_text import is_number
from symdyn.base.units import UnitError, parse_quantity, quantity_in_si
from symdyn.base.wording import did_you_mean, quoted
from symdyn.spec.dh_reader import joint_variable_offset
from symdyn.spec.number_paths import number_paths
from symdyn.spec.records import Robot
from symdyn.spec.toml_positions import KeyPath
from symdyn.spec.toml_source import parse

_EDITED = "edited text"


def add_effect(text: str, type: str, at: str, values: Mapping[str, str], comment: str = "") -> str:
    """Append an ``[[effect]]`` block; ``values`` as a file writes them (``{"level": "20.4 N"}``).

    ``comment`` becomes a comment line in it. InputError (SD101) where a key is no name.
    """
    for key in (type, *values):
        problem = identifier_problem(key)
        if problem is not None:
            raise InputError(Problem(problem.code, problem.message, Where(_EDITED), problem.hint))
    document = tomlkit.parse(_checked(text))
    block = tomlkit.table()
    if comment:
        block.add(tomlkit.comment(" ".join(comment.split())))
    block.add("type", type)
    block.add("at", at)
    for key, value in values.items():
        block.add(key, value)
    effects = document.get("effect")
    if isinstance(effects, Array) and not isinstance(effects, AoT):  # effect = [ { .. }, .. ]
        inline = tomlkit.inline_table()
        inline.update({"type": type, "at": at, **values})
        effects.add_line(inline)  # on a line of its own: the last line may end in a comment
        return _checked(tomlkit.dumps(document))
    appended = tomlkit.document()
    appended.add("effect", tomlkit.aot())
    appended["effect"].append(block)
    return _checked(f"{text.rstrip()}\n\n{tomlkit.dumps(appended).strip()}\n".lstrip("\n"))


def set_effect(text: str, type: str, at: str, values: Mapping[str, str], comment: str = "") -> str:
    """The effect of this type at this place with these values: its block changed, or a new one appended."""
    document = tomlkit.parse(_checked(text))
    block = next((e for e in document.get("effect", ()) if e.get("type") == type and e.get("at") == at), None)
    if block is None:
        return add_effect(text, type, at, values, comment)
    for key, value in values.items():
        block[key] = value
    return _checked(tomlkit.dumps(document))


def free_rotor(text: str, robot: Robot, joint: str, rotor: str, shaft: Mapping[str, str]) -> str:
    """Let a rotor that is fixed to its joint turn by itself, on a shaft to the joint (a row of ``shafts``).

    The effort of a joint without a motor acts on that rotor then. InputError (SD104) where the robot has no such rotor.
    """
    document = tomlkit.parse(_checked(text))
    names = [j.name for j in robot.joints]
    if joint not in names:
        raise InputError(Problem("SD104", f"no joint {quoted(joint)}", Where(_EDITED), did_you_mean(joint, names)))
    drive = document["joint"][names.index(joint)].get("drive", {})
    row = next((r for r in drive.get("rotors", ()) if r["name"] == rotor), None)
    if row is None:
        raise InputError(Problem("SD104", f"{quoted(joint)} has no rotor {quoted(rotor)}", Where(_EDITED)))
    row.pop("fixed_to_joint", None)
    inline = tomlkit.inline_table()
    inline.update(shaft)
    if "shafts" not in drive:
        drive["shafts"] = tomlkit.array()
    drive["shafts"].append(inline)
    if "motor" not in drive:
        drive["effort_at"] = rotor
    return _checked(tomlkit.dumps(document))


def set_gravity(text: str, gravity: Sequence[float]) -> str:
    """Give the robot another gravity (3,), in m/s^2, as plain numbers."""
    document = tomlkit.parse(_checked(text))
    document["robot"]["gravity"] = [float(value) for value in gravity]
    return _checked(tomlkit.dumps(document))


def set_parameter(text: str, robot: Robot, name: str, value_text: str) -> str:
    """Give a parameter another value (``"203.5 N s/m"``), where it is defined: its entry, or the literal in the tree.

    ``robot`` was read from ``text``, perhaps before other edits; a dimensionless parameter takes a bare number.
    InputError where there is no such parameter (SD104) or the value is none of its dimension (SD221, SD222).
    """
    unit = next((parameter.unit for parameter in robot.parameters if parameter.name == name), None)
    if unit is None:
        hint = did_you_mean(name, [parameter.name for parameter in robot.parameters], "parameters")
        raise InputError(Problem("SD104", f"no parameter {quoted(name)}", Where(_EDITED), hint))
    path = _path_of(robot, name)
    document = tomlkit.parse(_checked(text))
    try:
        value = _value(value_text.strip(), unit)
        _set(document, path, value)
    except UnitError as error:
        raise InputError(Problem(error.code, f"{name}: {error.message}", Where(_EDITED), error.hint)) from None
    except LookupError:
        problem = Problem("SD104", f"this text does not define {quoted(name)}", Where(_EDITED))
        raise InputError(problem) from None
    return _checked(tomlkit.dumps(document))


@dataclass(frozen=True, slots=True)
class _Value:
    """A checked value: the whole text, its number and its unit ("" for a bare number)."""

    text: str
    number: str
    unit: str


def _value(text: str, expected_unit: str) -> _Value:
    if expected_unit == "1" and is_number(text):
        return _Value(text, text, "")
    quantity_in_si(text, expected_unit)
    unit = parse_quantity(text)[1].text
    return _Value(text, text.removesuffix(unit).rstrip(), unit)


def _set(document: tomlkit.TOMLDocument, path: KeyPath, value: _Value) -> None:
    if path[0] == "parameters":
        _set_entry(_child(document, path[:1]), path[1], value)
    elif path[0] == "dh":
        _set_dh(_child(document, path[:-1]), path[-1], value)
    else:
        _child(document, path[:-1])[path[-1]] = _scalar(value)


def _scalar(value: _Value) -> Any:
    return value.text if value.unit else _toml_number(value.number)


def _toml_number(number: str) -> Any:
    """The number as it was written, where TOML can write it so ("1/12" stays a text)."""
    try:
        return tomlkit.value(number)
    except TOMLKitError:
        return number


def _path_of(robot: Robot, name: str) -> KeyPath:
    """Where the file defines a parameter."""
    if name in parse(robot.text, _EDITED).data.get("parameters", {}):
        return ("parameters", name)
    return next(path for path, monomial in number_paths(robot) if monomial.factors == ((name, 1),))


def _set_entry(parameters: Any, name: Any, value: _Value) -> None:
    entry = parameters[name]
    if not isinstance(entry, dict):
        parameters[name] = _scalar(value)
    elif "unit" in entry and "value" in entry and value.unit:
        entry["value"] = _toml_number(value.number)
        entry["unit"] = value.unit
    elif "value" in entry:
        entry["value"] = _scalar(value)
    else:  # it was left free
        _free_to_value(parameters, name, tomlkit.item(_scalar(value)))


def _free_to_value(parameters: Any, name: Any, value: Item) -> None:
    entry = parameters[name]
    unit = entry["free" if "free" in entry else "unit"]
    value.trivia.comment_ws, value.trivia.comment = unit.trivia.comment_ws, unit.trivia.comment
    kept = {key: entry[key] for key in list(entry) if key not in ("unit", "free")}
    if isinstance(entry, InlineTable):
        entry = parameters[name] = tomlkit.inline_table()
    entry.clear()
    entry.update({"value": value, **kept})


def _set_dh(row: Any, column: Any, value: _Value) -> None:
    """Keep the joint variable: ``"q - 0.1 m"`` becomes ``"q + 0.2 m"``."""
    if joint_variable_offset(row[column]) is None:
        row[column] = value.text
        return
    sign = "-" if value.text.startswith("-") else "+"
    row[column] = f"q {sign} {value.text.lstrip('+- ')}"


def _child(node: Any, path: KeyPath) -> Any:
    for part in path:
        node = node[part]
    return node


def _checked(text: str) -> str:
    parse(text, _EDITED)
    return text
