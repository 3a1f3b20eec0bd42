"""Several shape parameters of one effect, moved together: logarithms of what is positive, angles within two turns."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from symdyn.numeric.scan import POSITIVE
from symdyn.spec.effect_schema import ParameterSchema, Scan

Array = NDArray[np.float64]

STEPS = 15  # of a least-squares search
SETTLED = 1e-5  # relative fall of what is left: of a hundred thousand samples' noise, that of one
STARTS = 3  # beside the best of the grid
APART = 2  # steps of the grid, in some parameter, between two starts
BEYOND = 2.0  # factor that a search may leave the grid by
NUDGE = 1e-3


class ShapeSpace:
    """``axes`` are the grid's values of each parameter, rising."""

    def __init__(self, schemas: Sequence[ParameterSchema], axes: Sequence[Sequence[float]]) -> None:
        self.axes = axes
        self.log = [schema.scan in POSITIVE for schema in schemas]
        turns = [schema.scan is Scan.ANGLE for schema in schemas]
        low, high = [], []
        for axis, log, turn in zip(axes, self.log, turns, strict=True):
            ends = (axis[0] / BEYOND, axis[-1] * BEYOND) if log else (axis[0], axis[-1])
            low.append(-2.0 * np.pi if turn else np.log(ends[0]) if log else ends[0])
            high.append(2.0 * np.pi if turn else np.log(ends[1]) if log else ends[1])
        self.low, self.high = np.array(low), np.array(high)

    def apart(
        self, values: Sequence[tuple[float, ...]], losses: Sequence[float], best: tuple[float, ...]
    ) -> list[tuple[float, ...]]:
        """The best points of the grid that are no neighbours of one another: valleys may be several."""
        found = [best]
        for at in np.argsort(losses, kind="stable"):
            if len(found) > STARTS:
                break
            if all(self._steps(values[at], other) >= APART for other in found):
                found.append(values[at])
        return found[1:]

    def least_squares(
        self, residual: Callable[[tuple[float, ...]], Array], start: tuple[float, ...]
    ) -> tuple[float, ...]:
        """The shapes that leave least, near a start."""
        inside = 1e-6 * (1.0 + np.abs(self.high - self.low))
        x = np.clip(self._inwards(start), self.low + inside, self.high - inside)

        def left(x: Array) -> Array:
            return residual(self._outwards(x))

        found = optimize.least_squares(
            left,
            x,
            bounds=(self.low, self.high),
            diff_step=np.full(len(x), NUDGE),
            ftol=SETTLED,
            max_nfev=STEPS,
        )
        return self._outwards(found.x)

    def _inwards(self, shapes: tuple[float, ...]) -> Array:
        return np.array([np.log(v) if log else v for v, log in zip(shapes, self.log, strict=True)])

    def _outwards(self, x: Array) -> tuple[float, ...]:
        return tuple(float(np.exp(v)) if log else float(v) for v, log in zip(x, self.log, strict=True))

    def _steps(self, one: tuple[float, ...], other: tuple[float, ...]) -> int:
        """How many steps of the grid two points are apart, in the parameter where they differ most."""
        places = [
            [int(np.argmin(np.abs(np.array(a) - v))) for a, v in zip(self.axes, p, strict=True)] for p in (one, other)
        ]
        return int(np.max(np.abs(np.subtract(places[0], places[1]))))
