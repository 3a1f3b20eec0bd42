"""The decorator of what Numba compiles here, with the type of a plain function."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compiled and cached; a product and a sum may be rounded as one, and nothing else is rearranged."""
    return cast(F, njit(cache=True, error_model="numpy", fastmath={"contract"})(function))
