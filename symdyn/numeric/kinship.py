"""Laws that contain one another, and the candidates that are open to a search because of what was found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.numeric.candidates import Candidate, Key
from symdyn.physics import catalogue
from symdyn.physics.effect import Effect
from symdyn.spec.records import Robot


def ready(proposed: Sequence[Candidate], robot: Robot, effects: frozenset[Key]) -> list[Candidate]:
    """Candidates not yet in the model, or another of a kind that repeats, whose basis (what they correct) is in it.

    A law that is akin to one that was found is no addition to that: it may take its place (``nested``). Some laws wait
    for what they contain.
    """
    present = _present(robot, effects)
    return [
        _another(c, effects)
        for c, law in _not_akin(proposed, effects)
        if (c.repeats or (c.effect, c.place.address) not in present)
        and (c.builds_on is None or (c.builds_on, c.place.address) in present)
        and (law.opens or any((e, c.place.address) in present for e in law.generalises))
    ]


def waiting(proposed: Sequence[Candidate], robot: Robot, effects: frozenset[Key]) -> list[Candidate]:
    """Candidates that wait for what they contain, which is not there; where nothing else earns its place they may.

    Whatever they resemble was asked by then.
    """
    present = _present(robot, effects)
    return [
        c
        for c, law in _not_akin(proposed, effects)
        if not law.opens and not any((e, c.place.address) in present for e in (c.effect, *law.generalises))
    ]


def _present(robot: Robot, effects: frozenset[Key]) -> set[tuple[str, str]]:
    return {(effect, at) for effect, at, _ in effects} | {(e.type, e.at) for e in robot.effects}


def _not_akin(proposed: Sequence[Candidate], effects: frozenset[Key]) -> list[tuple[Candidate, Effect]]:
    """Those that are no kin of what was found at their place, each with its law."""
    return [
        (c, catalogue()[c.effect])
        for c in proposed
        if not any(at == c.place.address and akin(c.effect, other) for other, at, _ in effects)
    ]


def _another(candidate: Candidate, effects: frozenset[Key]) -> Candidate:
    """The same, or one more of its kind where there is one already."""
    numbers = [number for effect, at, number in effects if (effect, at) == candidate.key[:2]]
    return replace(candidate, number=max(numbers) + 1) if numbers else candidate


def akin(one: str, other: str) -> bool:
    """Whether two effects contain one another, or a third: Coulomb's law, say, that of Dahl, and that of LuGre."""
    first, second = ({effect, *catalogue()[effect].generalises} for effect in (one, other))
    return one != other and bool(first & second)
