"""The servo loops of a robot: which are sampled; the robot with its loops run without pause, and without them."""

from __future__ import annotations

from dataclasses import replace

from symdyn.physics import effect as find_effect
from symdyn.physics.servo_loop import SAMPLING, ServoLoop
from symdyn.spec.monomials import value_of
from symdyn.spec.records import ZERO, EffectSpec, Robot

_SAMPLED = frozenset(parameter.name for parameter in SAMPLING)


def periods(robot: Robot) -> tuple[tuple[EffectSpec, float], ...]:
    """The sampled loops with their periods in s; those whose period is left free are not among them."""
    numbers = {p.name: p.value for p in robot.parameters}
    found = (
        (declared, value_of(dict(declared.values)["period"], numbers)) for declared in robot.effects if _is(declared)
    )
    return tuple((declared, float(period)) for declared, period in found if period)


def continuous(robot: Robot) -> Robot:
    return replace(robot, effects=tuple(_continuous(e) if _is(e) else e for e in robot.effects))


def without_loops(robot: Robot) -> Robot:
    return replace(robot, effects=tuple(e for e in robot.effects if not _is(e)))


def _is(declared: EffectSpec) -> bool:
    return isinstance(find_effect(declared.type), ServoLoop)


def _continuous(declared: EffectSpec) -> EffectSpec:
    values = tuple((name, ZERO if name in _SAMPLED else value) for name, value in declared.values)
    return replace(declared, values=values)
