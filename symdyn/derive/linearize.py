"""The linear part of a machine: what remains when its non-smooth effects are taken away."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import sympy as sp

from symdyn.base import symbols
from symdyn.base.nonsmooth import is_smooth
from symdyn.derive.quantities import effect_values
from symdyn.physics import effect as find_effect
from symdyn.physics.effect import PORT, Effect, Values
from symdyn.spec.monomials import value_of
from symdyn.spec.records import ZERO, EffectSpec, Robot

_CONTROL = symbols.control(1)


def without_nonsmooth(robot: Robot) -> Robot:
    """The robot less its effects that jump (T_f = 0, S = 0 in the seed's words).

    Of a sensor that jumps only what makes it jump is taken away (the resolution of an encoder). Hidden
    states stay, kinks in their rates too: at rest, bristles are springs.
    """
    kept = (_smoothed(declared) for declared in robot.effects)
    return replace(robot, effects=tuple(declared for declared in kept if declared is not None))


def without_null_effects(robot: Robot) -> Robot:
    """The robot less its effects whose parameters, as given, make them vanish exactly."""
    numbers = {p.name: p.value for p in robot.parameters}
    return replace(robot, effects=tuple(e for e in robot.effects if not _is_null(e, numbers)))


def _is_null(declared: EffectSpec, numbers: Mapping[str, float | None]) -> bool:
    given = dict(declared.values)
    known = [p for p in find_effect(declared.type).parameters if p.null is not None and p.name in given]
    return bool(known) and all(value_of(given[p.name], numbers) == p.null for p in known)


def _smoothed(declared: EffectSpec) -> EffectSpec | None:
    item = find_effect(declared.type)
    if _is_smooth(item, effect_values(item, declared.values)):
        return declared
    for parameter in reversed(item.parameters):
        if parameter.zero_is_structural:
            values = tuple((name, ZERO if name == parameter.name else value) for name, value in declared.values)
            if _is_smooth(item, effect_values(item, values)):
                return replace(declared, values=values)
    return None


def _is_smooth(item: Effect, values: Values) -> bool:
    return all(map(is_smooth, _laws(item, values)))


def _laws(item: Effect, values: Values) -> Iterator[sp.Expr]:
    yield from (law(PORT, values) for law in (item.force, item.potential_energy, item.dissipation))
    z = tuple(symbols.hidden(k) for k, _ in enumerate(item.hidden_states(values), start=1))
    through = item.transmission(PORT, values)
    amplified, sensor = item.amplified(values, z, _CONTROL), item.sensor(PORT, values, z)
    yield from () if through is None else (through.x, through.v)
    yield from () if amplified is None else (amplified,)
    yield from () if sensor is None else (sensor.value,)
