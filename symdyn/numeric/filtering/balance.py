"""Where parts that nobody measures are as a recording begins: bent until they go along with those that are measured."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from symdyn.emit.kernel import Kernel
from symdyn.numeric.filtering.gears import BASELINE
from symdyn.numeric.filtering.signals import Signals, opening

Array = NDArray[np.float64]

SPAN = 5.0 * BASELINE  # s over which a position tells an acceleration
SWEEPS = 3  # over the hidden parts, each of which bends the next
FARTHEST = 16.0  # times the bend that is expected: where a balance is looked for


@dataclass(frozen=True, slots=True, eq=False)
class Balance:
    """``hidden`` coordinates, how far (h,) each may be ``bent`` and its ``acceleration`` (h,), if it goes along."""

    kernel: Kernel
    u: Array
    hidden: tuple[int, ...]
    bent: Array
    acceleration: Array

    def found(self, p: Array, start: Array) -> Array:
        """(n,) the state at the start, its hidden parts in balance at parameters ``p`` (np,).

        A filter that begins between the flanks of a gear that its load holds on one of them believes for ever what
        it computes there: nothing couples the two sides.
        """
        x, n = start.copy(), len(self.kernel.coordinates)

        def excess(i: int, wanted: float, q: float) -> float:
            x[i] = q
            return float(self.kernel.state_derivative_p(x, self.u, p)[n + i]) - wanted

        for _ in range(SWEEPS if len(self.hidden) > 1 else 1):
            for i, bent, wanted in zip(self.hidden, self.bent, self.acceleration, strict=True):
                x[i] = _crossing(partial(excess, i, wanted), float(x[i]), bent)
        return x


def balance(kernel: Kernel, signals: Signals, hidden: Sequence[int], bend: Array, turns: Array) -> Balance:
    """Of the ``hidden`` coordinates those that ``bend`` (c,); ``turns`` (c,) per turn of their joint."""
    joints = [name.partition(".")[0] for name in kernel.coordinates]
    shown = {joints[i]: (i, c) for c, i in enumerate(signals.index) if i < len(joints)}
    known = [i for i in hidden if bend[i] > 0.0 and joints[i] in shown]
    along = []
    for i in known:
        measured, channel = shown[joints[i]]
        along.append(opening(signals, signals.y[:, channel], SPAN)[1] * turns[i] / turns[measured])
    return Balance(kernel, signals.u[0], tuple(known), bend[known], np.array(along))


def _crossing(excess: Callable[[float], float], start: float, bent: float) -> float:
    """Where what falls with the position is zero, or the start, if that is nowhere near."""
    first = excess(start)
    reach = np.copysign(bent, first)
    while abs(reach) <= FARTHEST * bent:
        if excess(start + reach) * first <= 0.0:
            return float(optimize.brentq(excess, start, start + reach, xtol=1e-3 * bent))
        reach *= 2.0
    return start
