"""The decorator of what Numba compiles here, with the type of a plain function."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compiled and cached; each operation is rounded by itself, so that numbers do not depend on what is inlined where.

    Only ``vectors`` round a product and a sum as one, in a single way.
    """
    return cast(F, njit(cache=True, error_model="numpy")(function))


def inlined(function: F) -> F:
    """The same, in the code of its callers: arrays are dear as arguments."""
    return cast(F, njit(cache=True, error_model="numpy", forceinline=True)(function))
