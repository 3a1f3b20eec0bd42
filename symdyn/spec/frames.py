"""How a joint is placed and which way it moves: what the readers of all kinds of geometry give."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.spec.records import DHRow, JointKind, Placement


@dataclass(frozen=True, slots=True)
class JointFrame:
    kind: JointKind
    placement: DHRow | Placement
