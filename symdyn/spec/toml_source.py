"""A TOML file as data that knows where each of its values stands."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from symdyn.base.errors import InputError, Problem, Where
from symdyn.base.wording import quoted
from symdyn.spec.toml_positions import KeyPath, Positions, positions_of

LARGEST_FILE = 1 << 20  # bytes
DEEPEST_NESTING = 64

_AT = re.compile(r" \(at (?:line (?P<line>\d+), column (?P<column>\d+)|end of document)\)$")
_DECIMAL_COMMA = re.compile(r"=\s*[+-]?\d+,\d")
_LONG_DOTTED_KEY = re.compile(rf"""(?<![\w"'-])(?:[\w"'-]++[ \t]*+\.[ \t]*+){{{DEEPEST_NESTING + 1}}}""")
_REPEATED = ("Cannot overwrite", "Cannot declare", "Cannot mutate", "Duplicate inline table key")


@dataclass(frozen=True)
class TomlSource:
    """Text, parsed data, and the place of every key path."""

    text: str
    file: str
    data: dict[str, Any]

    def where(self, path: KeyPath, *, key: bool = False) -> Where:
        """Place of the value at a key path (of its key, if ``key``), or of the nearest table around it."""
        position = self._positions.find(path, key=key)
        return Where(self.file, position.line, position.column) if position else Where(self.file)

    @cached_property
    def _positions(self) -> Positions:
        return positions_of(self.text)


def read_text(path: str | Path, largest: int = LARGEST_FILE) -> str:
    """The text of a file: UTF-8, at most ``largest`` bytes. InputError SD003, SD004 or SD005 otherwise."""
    file = str(path)
    try:
        with open(path, "rb") as stream:
            content = stream.read(largest + 1)
    except IsADirectoryError:
        raise _unreadable(file, "is a directory", "name the file in it") from None
    except FileNotFoundError:
        raise _unreadable(file, "does not exist") from None
    except OSError as error:
        raise _unreadable(file, f"cannot be read: {error.strerror}") from None
    except ValueError as error:  # a NUL in the path
        raise _unreadable(file, f"cannot be read: {error}") from None
    if len(content) > largest:
        raise InputError(Problem("SD004", f"the file is larger than {largest >> 20} MiB", Where(file)))
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        column = len(content[content.rfind(b"\n", 0, error.start) + 1 : error.start].decode()) + 1
        raise InputError(Problem("SD005", "not UTF-8 text", Where(file, line, column), "save it as UTF-8")) from None


def parse(text: str, file: str) -> TomlSource:
    """Parse a TOML text. InputError SD001 (syntax) or SD002 (nested too deep)."""
    text = text.replace("\r\n", "\n")
    try:
        size = len(text.encode())
    except UnicodeEncodeError:
        raise InputError(Problem("SD005", "not UTF-8 text: it holds half of a surrogate pair", Where(file))) from None
    if size > LARGEST_FILE:
        raise InputError(Problem("SD004", "the text is larger than 1 MiB", Where(file)))
    if too_long := _LONG_DOTTED_KEY.search(text):  # tomllib takes quadratic time over them
        raise _too_deep(file, text, too_long.start())
    try:
        data = tomllib.loads(text)
    except RecursionError:
        raise _too_deep(file, text, _deepest(text)) from None
    except ValueError as error:  # TOMLDecodeError, or an integer of thousands of digits
        raise InputError(_syntax_problem(str(error), text, file)) from None
    if _is_too_deep(data):
        raise _too_deep(file, text, _deepest(text))
    return TomlSource(text, file, data)


def _syntax_problem(message: str, text: str, file: str) -> Problem:
    at = _AT.search(message)
    what = message[: at.start()] if at else message
    if what.startswith(_REPEATED):
        positions = positions_of(text)
        if positions.repeated:
            path, again, first = positions.repeated[0]
            name = ".".join(part for part in path if isinstance(part, str))
            here, there = positions.position(again), positions.position(first)
            return Problem(
                "SD001",
                f"{quoted(name)} is defined twice, first at {Where(file, there.line, there.column)}",
                Where(file, here.line, here.column),
                "remove one of them",
            )
    lines = text.split("\n")
    line, column = (int(at["line"]), int(at["column"])) if at and at["line"] else (len(lines), len(lines[-1]) + 1)
    hint = ""
    if "integer string conversion" in what and (digits := re.search(r"\d{4300,}", text)):
        line = text.count("\n", 0, digits.start()) + 1
        column = digits.start() - text.rfind("\n", 0, digits.start())
        what = "a number of thousands of digits"
    elif _DECIMAL_COMMA.search(lines[line - 1]):
        hint = "write a decimal point: 1.5"
    elif lines[line - 1].count("{") > lines[line - 1].count("}"):
        hint = "an inline table { ... } stands on one line"
    return Problem("SD001", f"not valid TOML: {what}", Where(file, line, column), hint)


def _is_too_deep(data: dict[str, Any]) -> bool:
    level: list[Any] = [data]
    for _ in range(DEEPEST_NESTING):
        level = [
            child
            for node in level
            for child in (node.values() if isinstance(node, dict) else node)
            if isinstance(child, dict | list)
        ]
        if not level:
            return False
    return True


def _deepest(text: str) -> int:
    """Offset of the bracket that goes too deep (brackets in strings count: good enough to point at it)."""
    depth = 0
    for bracket in re.finditer(r"[\[\]{}]", text):
        depth = max(0, depth + (1 if bracket[0] in "[{" else -1))
        if depth > DEEPEST_NESTING:
            return bracket.start()
    return 0


def _too_deep(file: str, text: str, offset: int) -> InputError:
    line = text.count("\n", 0, offset) + 1
    column = offset - text.rfind("\n", 0, offset)
    return InputError(Problem("SD002", f"nested deeper than {DEEPEST_NESTING} levels", Where(file, line, column)))


def _unreadable(file: str, message: str, hint: str = "") -> InputError:
    return InputError(Problem("SD003", message, Where(file), hint))
