"""The linear part of a machine: what remains when its non-smooth effects are taken away."""

from __future__ import annotations

from dataclasses import replace

from symdyn.base import symbols
from symdyn.base.nonsmooth import is_smooth
from symdyn.physics import effect
from symdyn.physics.effect import PORT
from symdyn.spec.records import Robot


def without_nonsmooth(robot: Robot) -> Robot:
    """The robot less its effects that jump (T_f = 0, S = 0 in the seed's words)."""
    return replace(robot, effects=tuple(e for e in robot.effects if _smooth(e.type)))


def _smooth(identifier: str) -> bool:
    item = effect(identifier)
    values = {p.name: symbols.parameter(p.name) for p in item.parameters}
    if item.transmission(PORT, values) is not None:
        return False
    laws = (item.force, item.potential_energy, item.dissipation)
    return all(is_smooth(law(PORT, values)) for law in laws)
