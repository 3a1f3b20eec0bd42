"""Forces of candidates that were asked for before, as many as there is room for."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Key = tuple[str, tuple[float, ...]]  # a law, and its shapes

ROOM = 2**28  # bytes, of one joint on one recording: ten seconds at 1 kHz never need it, half an hour would need 20 GB


class Kept:
    """By law and shapes. What came first stays: the values of a scan, which every later step asks for again.

    What a search finds between those comes later, and is mostly asked for once.
    """

    def __init__(self, room: int = ROOM) -> None:
        self._forces: dict[Key, Array] = {}
        self._room = room

    def of(self, key: Key, force: Callable[[], Array]) -> Array:
        known = self._forces.get(key)
        if known is not None:
            return known
        made = force()
        if made.nbytes <= self._room:
            self._room -= made.nbytes
            self._forces[key] = made
        return made
