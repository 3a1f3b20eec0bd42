"""Collects what is wrong with a file, with places, so that all of it is told at once."""

from __future__ import annotations

from typing import Protocol

from symdyn.base.errors import InputError, Problem, Where
from symdyn.spec.toml_positions import KeyPath


class Source(Protocol):
    """A text that knows where the things that a key path names stand in it."""

    def where(self, path: KeyPath, *, key: bool = False) -> Where: ...


class Findings:
    """Errors and warnings of one source. A key path is blamed once: what follows from the first error is noise."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self._errors: list[Problem] = []
        self._warnings: list[Problem] = []
        self._blamed: set[KeyPath] = set()
        self._touched: set[KeyPath] = set()  # the blamed paths and all that holds them

    def error(self, path: KeyPath, code: str, message: str, hint: str = "", *, key: bool = False) -> None:
        """Add an error at the value of a key path, or at its ``key``."""
        if path not in self._blamed:
            self._blamed.add(path)
            self._touched.update(path[:length] for length in range(1, len(path) + 1))
            self._errors.append(Problem(code, message, self.where(path, key=key), hint))

    def warning(self, path: KeyPath, code: str, message: str, hint: str = "") -> None:
        if path not in self._blamed:
            self._warnings.append(Problem(code, message, self.where(path), hint))

    def is_blamed(self, path: KeyPath) -> bool:
        return path in self._blamed

    def is_blamed_within(self, path: KeyPath) -> bool:
        """Whether there is an error at the path, or anywhere inside."""
        return path in self._touched

    def where(self, path: KeyPath, *, key: bool = False) -> Where:
        return self.source.where(path, key=key)

    @property
    def warnings(self) -> tuple[Problem, ...]:
        return tuple(sorted(self._warnings, key=_order))

    @property
    def has_errors(self) -> bool:
        return bool(self._errors)

    def raise_errors(self) -> None:
        """InputError with every error, in the order of the file, if there is one."""
        if self._errors:
            raise InputError(sorted(self._errors, key=_order))


def _order(problem: Problem) -> tuple[int, int]:
    where = problem.where
    return (where.line or 0, where.column or 0) if where else (0, 0)
