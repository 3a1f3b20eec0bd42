"""Finds the targets: every module of this package holds one as ``TARGET``; adding a file here adds a target."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from symdyn.base.errors import Problem, UsageError
from symdyn.base.wording import did_you_mean, quoted
from symdyn.emit.target import Target

DEFAULT_TARGET = "numba"


@cache
def targets() -> Mapping[str, Target]:
    """All targets by name, in alphabetical order."""
    modules = [importlib.import_module(f"{__name__}.{info.name}") for info in pkgutil.iter_modules(__path__)]
    found: dict[str, Target] = {module.TARGET.name: module.TARGET for module in modules}
    return MappingProxyType(dict(sorted(found.items())))


def target(name: str) -> Target:
    """The target of that name; raises UsageError (SD012) if there is none."""
    if name not in targets():
        raise UsageError(Problem("SD012", f"no target {quoted(name)}", hint=did_you_mean(name, targets(), "targets")))
    return targets()[name]
