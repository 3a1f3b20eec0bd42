"""Finds the effects: every module in ``effects/`` holds one; adding a file there adds an effect."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache

from symdyn.base import symbols
from symdyn.physics import effects
from symdyn.physics.effect import PORT, Effect
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


@cache
def schemas() -> Mapping[str, EffectSchema]:
    """What readers of files need to know of the catalogue."""
    return {identifier: item.schema() for identifier, item in catalogue().items()}


@cache
def load_dependent() -> frozenset[str]:
    """Identifiers of the effects whose force depends on the load at their place: another load tells them apart."""
    found = []
    for identifier, item in catalogue().items():
        p = {schema.name: symbols.local(schema.name) for schema in item.parameters}
        if item.force(PORT, p).has(PORT.load):
            found.append(identifier)
    return frozenset(found)
