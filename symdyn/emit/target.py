"""What a target is: a name, and how the forms of a robot's functions become files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from symdyn.derive.equations import EquationsOfMotion
from symdyn.emit.forms import Form


@dataclass(frozen=True, slots=True)
class Target:
    """A language that a robot's functions are printed in.

    ``emit`` returns the text of every file by its name; the same robot must give the same bytes.
    ``templates`` are those that it fills: their hash goes into the manifest.
    """

    name: str  # as in ``symdyn generate --target NAME``
    title: str
    emit: Callable[[EquationsOfMotion, Sequence[Form]], Mapping[str, str]]
    templates: tuple[str, ...] = ()
