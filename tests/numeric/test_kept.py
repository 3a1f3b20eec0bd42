"""What came first is kept, up to a size; everything else is made again, and is the same."""

from __future__ import annotations

import numpy as np

from symdyn.numeric.kept import Kept


def test_what_there_is_no_room_for_is_made_again() -> None:
    made: list[float] = []
    kept = Kept(room=2 * np.zeros(10).nbytes)

    def value(shape: float) -> float:
        def force() -> np.ndarray[tuple[int], np.dtype[np.float64]]:
            made.append(shape)
            return np.full(10, shape)

        return float(kept.of(("law", (shape,)), force)[0])

    assert [value(shape) for shape in (1.0, 2.0, 3.0, 1.0, 2.0, 3.0)] == [1.0, 2.0, 3.0, 1.0, 2.0, 3.0]
    assert made == [1.0, 2.0, 3.0, 3.0]
