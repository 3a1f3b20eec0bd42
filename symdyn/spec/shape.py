"""Checks the shape of parsed TOML against its schema, and tells the misfits in our own words."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from symdyn.base.wording import closest, did_you_mean, quoted
from symdyn.spec.findings import Findings
from symdyn.spec.schema import NUMBER_ERRORS, OWN_ERRORS
from symdyn.spec.toml_positions import KeyPath

Shape = TypeVar("Shape", bound=BaseModel)

_TABLES = ("model_type", "model_attributes_type", "dict_type")
_ARRAYS = ("list_type",)
_LENGTHS = ("too_short", "too_long")


def validated(shape: type[Shape], given: dict[str, Any], findings: Findings) -> Shape | None:
    """The parsed data in the given shape.

    Misfits are added to the findings. Those that can be taken out (an unknown key, a value of the wrong type) are,
    so that the rest of the file can be checked too; None where that is not possible.
    """
    data = copy.deepcopy(given)
    try:
        return shape.model_validate(data)
    except ValidationError as error:
        details = error.errors(include_url=False)
    slips = _slips(shape, details)
    for detail in details:
        if detail["type"] != "missing" or detail["loc"] not in slips:
            _tell(shape, detail, findings)
        _take_out(data, detail)
    try:
        return shape.model_validate(data)
    except ValidationError:
        return None


def _tell(shape: type[BaseModel], detail: ErrorDetails, findings: Findings) -> None:
    path, kind = detail["loc"], detail["type"]
    name = quoted(path[-1]) if path else "file"
    if kind == "extra_forbidden":
        options = _keys_of(_table_at(shape, path[:-1]))
        findings.error(path, "SD104", f"unknown key {name}", did_you_mean(str(path[-1]), options, "keys"), key=True)
    elif kind == "missing":
        parent = f"table {quoted(_dotted(path[:-1]))}" if path[:-1] else "file"
        findings.error(path, "SD107", f"the {parent} has no {name}")
    elif kind == "literal_error":
        findings.error(path, "SD202", f"{name}: expected {detail['ctx']['expected']}, found {quoted(detail['input'])}")
    elif kind in _TABLES:
        findings.error(path, "SD202", f"{name} must be a table")
    elif kind in _ARRAYS:
        hint = f"write [[{_dotted(path)}]]" if path in (("joint",), ("effect",), ("recording", "channel")) else ""
        findings.error(path, "SD202", f"{name} must be an array", hint)
    elif kind in _LENGTHS:
        bound = detail["ctx"].get("min_length", detail["ctx"].get("max_length"))
        side = "at least" if kind == "too_short" else "at most"
        findings.error(
            path, "SD202", f"{name} has {detail['ctx']['actual_length']} elements, {side} {bound} are needed"
        )
    elif kind in OWN_ERRORS:
        findings.error(_written(path), OWN_ERRORS[kind], detail["msg"])
    else:
        findings.error(path, "SD202", f"{name}: {detail['msg']}")


def _slips(shape: type[BaseModel], details: list[ErrorDetails]) -> set[KeyPath]:
    """Missing keys that are there under a misspelt name: told once, as the unknown key."""
    return {
        (*detail["loc"][:-1], meant)
        for detail in details
        if detail["type"] == "extra_forbidden"
        and (meant := closest(str(detail["loc"][-1]), _keys_of(_table_at(shape, detail["loc"][:-1])))) is not None
    }


def _take_out(data: dict[str, Any], detail: ErrorDetails) -> None:
    """Remove what does not fit, or put 0 where a number should stand."""
    path = _written(detail["loc"])
    if detail["type"] == "missing" or not path:
        return
    parent: Any = data
    for part in path[:-1]:
        try:
            parent = parent[part]
        except (KeyError, IndexError, TypeError):
            return  # taken out already, with what holds it
    if detail["type"] in NUMBER_ERRORS and path[0] != "dh":
        parent[path[-1]] = 0
    elif isinstance(parent, dict):
        parent.pop(path[-1], None)


def _written(path: KeyPath) -> KeyPath:
    """``m = true`` is checked as ``m = { value = true }``: the path as it is written."""
    is_bare = len(path) == 3 and path[0] == "parameters" and path[2] == "value"
    return path[:2] if is_bare else path


def _table_at(shape: type[BaseModel], path: KeyPath) -> type[BaseModel] | None:
    """The schema of the table at a key path."""
    table: type[BaseModel] | None = shape
    is_user_named = False  # the next part is a user's name: [parameters]
    for part in path:
        if isinstance(part, int) or table is None:
            continue
        if is_user_named:
            is_user_named = False
            continue
        annotation = {info.alias or name: info.annotation for name, info in table.model_fields.items()}.get(part)
        is_user_named = get_origin(annotation) is dict
        table = next(_tables_in(annotation), None)
    return table


def _tables_in(annotation: object) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and not get_args(annotation) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in get_args(annotation):
        yield from _tables_in(argument)


def _keys_of(table: type[BaseModel] | None) -> list[str]:
    return [info.alias or name for name, info in table.model_fields.items()] if table is not None else []


def _dotted(path: KeyPath) -> str:
    return ".".join(part for part in path if isinstance(part, str))
