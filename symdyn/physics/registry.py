"""Finds the effects: every module in ``effects/`` holds one; adding a file there adds an effect."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Protocol, TypeVar

from symdyn.base import symbols
from symdyn.physics import effects
from symdyn.physics.effect import PORT, ZERO, Effect, Values
from symdyn.spec.effect_schema import EffectSchema


@cache
def catalogue() -> Mapping[str, Effect]:
    """All effects by identifier, in alphabetical order."""
    found: dict[str, Effect] = {}
    for module_info in pkgutil.iter_modules(effects.__path__):
        module = importlib.import_module(f"{effects.__name__}.{module_info.name}")
        for value in vars(module).values():
            if isinstance(value, type) and issubclass(value, Effect) and value.__module__ == module.__name__:
                found[value.identifier] = value()
    return dict(sorted(found.items()))


def effect(identifier: str) -> Effect:
    return catalogue()[identifier]


class Typed(Protocol):
    """What stands for an effect of that type somewhere."""

    @property
    def effect(self) -> str: ...


Of = TypeVar("Of", bound=Typed)


def in_stages(found: Iterable[Of]) -> list[Of]:
    """In the order in which a diagnosis adds them to a model: stages that a signal passes early come first."""
    return sorted(found, key=lambda each: effect(each.effect).stage)


@cache
def schemas() -> Mapping[str, EffectSchema]:
    """What readers of files need to know of the catalogue."""
    return {identifier: item.schema() for identifier, item in catalogue().items()}


@cache
def load_dependent() -> frozenset[str]:
    """Identifiers of the effects whose force depends on the load at their place: another load tells them apart."""
    return frozenset(name for name, item in catalogue().items() if item.force(PORT, _parameters(item)).has(PORT.load))


@cache
def with_play() -> frozenset[str]:
    """Identifiers of the effects that part what they join, within a clearance."""
    return frozenset(name for name, item in catalogue().items() if item.play(_parameters(item)) is not None)


@cache
def law_variables(identifier: str) -> frozenset[str]:
    """What an effect's force is a law in, of ``position`` and ``speed`` at its place; hidden states have none."""
    item = effect(identifier)
    p = _parameters(item)
    force = sum((item.force(PORT, p), item.conservative(p), item.damping(p)), ZERO)
    return frozenset(name for name, symbol in (("position", PORT.x), ("speed", PORT.v)) if force.has(symbol))


def _parameters(item: Effect) -> Values:
    return {schema.name: symbols.local(schema.name) for schema in item.parameters}
