"""Errors that say what is wrong, where, and what to do."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Where:
    """A place in an input: a file, with a 1-based line and column where they are known."""

    file: str
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        parts = [self.file, *(str(n) for n in (self.line, self.column) if n is not None)]
        return ":".join(parts)


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong.

    ``code`` is stable and can be searched for ("SD104"); ``message`` says what is wrong and
    ``hint`` what to do about it.
    """

    code: str
    message: str
    where: Where | None = None
    hint: str = ""

    def __str__(self) -> str:
        place = f"{self.where}: " if self.where else ""
        hint = f"\n    {self.hint}" if self.hint else ""
        return f"{place}{self.code}: {self.message}{hint}"


class SymdynError(Exception):
    """Base of all errors that symdyn raises on purpose; carries every problem found, not the first."""

    exit_code = 1

    def __init__(self, problems: Problem | Iterable[Problem]) -> None:
        self.problems: tuple[Problem, ...] = (problems,) if isinstance(problems, Problem) else tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))


class UsageError(SymdynError):
    """The command line asks for something that cannot be."""

    exit_code = 2


class InputError(SymdynError):
    """A model, a channel map or a recording is invalid."""

    exit_code = 3


class BadRecording(InputError):
    """A recording fails its checks: whatever were concluded from it would be about its faults."""


class NumericalError(SymdynError):
    """A computation failed: it diverged, or a matrix was singular."""

    exit_code = 4
