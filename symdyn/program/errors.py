"""The error of the program layer: an expression that cannot be lowered, or a malformed program."""

from __future__ import annotations

from symdyn.base.errors import Problem, SymdynError


class ProgramError(SymdynError):
    """A mistake of the caller of the compiler, never of a user's file."""

    def __init__(self, code: str, message: str, hint: str = "") -> None:
        super().__init__(Problem(code, message, hint=hint))
