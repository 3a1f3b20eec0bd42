"""Proof that a guard stays positive over a step, from its values and derivatives at both ends; its root if not."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.hybrid.compiled import compiled, inlined

Array = NDArray[np.float64]

HERMITE_8 = 1.0 / (256.0 * 40320.0)  # of the remainder h^8 g^(8) of the interpolation by two ends
HERMITE_7 = 0.00839 / 40320.0  # the same over the time since a root at the start


@inlined
def hopeless(values: Array, here: int, guards: int, bound: Array, rounding: Array, h: float) -> bool:
    """Whether ``margins`` cannot prove a step of length ``h``, as its start tells: the remainder alone is too large."""
    count = len(bound)
    remainder_per_bound = h * h * h * h * h * h * h * h
    for g in range(guards):
        remainder = bound[g] * remainder_per_bound
        start = values[here + g]
        if abs(start) <= rounding[g]:
            if values[here + count + g] * h <= HERMITE_7 * remainder and start + rounding[g] <= HERMITE_8 * remainder:
                return True
        elif start <= HERMITE_8 * remainder + rounding[g]:
            return True
    return False


@inlined
def _coefficients(values: Array, here: int, there: int, count: int, g: int, h: float) -> Any:
    """Bernstein's of the polynomial of degree 7 through both ends of a step; see ``margins``."""
    p0, p1 = values[here + g], values[there + g]
    here, there = here + count + g, there + count + g
    a1, a2, a3 = values[here], values[here + count], values[here + 2 * count]
    c1, c2, c3 = values[there], values[there + count], values[there + 2 * count]
    h1, h2, h3 = h / 7.0, h * h / 42.0, h * h * h / 210.0
    a1, a2, a3, c1, c2, c3 = a1 * h1, a2 * h2, a3 * h3, c1 * h1, c2 * h2, c3 * h3
    return (p0, p0 + a1, p0 + 2.0 * a1 + a2, p0 + 3.0 * a1 + 3.0 * a2 + a3,
            p1 - 3.0 * c1 + 3.0 * c2 - c3, p1 - 2.0 * c1 + c2, p1 - c1, p1)  # fmt: skip


@inlined
def _far(values: Array, here: int, there: int, count: int, g: int, h: float) -> float:
    """Less than all Bernstein coefficients, at a third of their price."""
    h1, h2, h3 = h * (3.0 / 7.0), h * h / 14.0, h * h * h / 210.0
    from_here = abs(values[here + count + g]) * h1 + abs(values[here + 2 * count + g]) * h2
    from_there = abs(values[there + count + g]) * h1 + abs(values[there + 2 * count + g]) * h2
    from_here += abs(values[here + 3 * count + g]) * h3
    from_there += abs(values[there + 3 * count + g]) * h3
    least: float = min(values[here + g] - from_here, values[there + g] - from_there)
    return least


@inlined
def margins(
    values: Array, here: int, there: int, guards: int, bound: Array, rounding: Array, h: float, margin: Array
) -> bool:
    """How far, at least, each guard stays above zero over a step of length ``h``; negative or zero: not proven. Whether
    all are.

    From ``here`` and ``there`` on, ``values`` are guards and three derivatives at both ends (4 G,), ``bound`` (G,)
    is on the eighth. The polynomial of degree 7 through both ends is above its least Bernstein coefficient, and the
    guard within the remainder of it; far from zero, the sizes of the derivatives tell as much. A guard that starts at
    its root is divided by the time since, or stays there: a force that is what friction can just hold.
    """
    count = len(margin)
    remainder_per_bound = h * h * h * h * h * h * h * h
    safe = True
    for g in range(guards):
        remainder = bound[g] * remainder_per_bound
        margin[g] = _far(values, here, there, count, g, h) - HERMITE_8 * remainder - rounding[g]
        if margin[g] > 0.0:
            continue
        b0, b1, b2, b3, b4, b5, b6, b7 = _coefficients(values, here, there, count, g, h)
        least = min(min(min(b0, b1), min(b2, b3)), min(min(b4, b5), min(b6, b7)))
        if abs(b0) <= rounding[g]:
            slope = min(
                min(min(b1 * 7.0, b2 * 3.5), min(b3 * 2.3333333333333335, b4 * 1.75)),
                min(min(b5 * 1.4, b6 * 1.1666666666666667), b7),
            )
            margin[g] = max(slope - HERMITE_7 * remainder, least + rounding[g] - HERMITE_8 * remainder)
        else:
            margin[g] = least - HERMITE_8 * remainder - rounding[g]
        safe = safe and not margin[g] <= 0.0
    return safe


@compiled
def crosses_once(
    values: Array, here: int, there: int, count: int, g: int, bound: Array, rounding: Array, h: float
) -> bool:
    """Whether a guard is positive, then negative: its polynomial's coefficients change sign once (Descartes)."""
    if not (values[here + g] > rounding[g] and values[there + g] < -rounding[g]):
        return False
    if HERMITE_8 * bound[g] * h**8 >= 1e-9 * (values[here + g] - values[there + g]):
        return False  # the polynomial may be another thing than the guard
    changes, positive = 0, True
    for value in _coefficients(values, here, there, count, g, h):
        changes += (value > 0.0) != positive
        positive = value > 0.0
    return changes == 1


@compiled
def root(values: Array, here: int, there: int, count: int, g: int, h: float) -> float:
    """Where in (0, 1] the polynomial through both ends of a step, positive at 0 and negative at 1, is zero."""
    b = _coefficients(values, here, there, count, g, h)
    low, high, at_low, at_high = 0.0, 1.0, b[0], b[7]
    side = 0
    for _ in range(60):  # Illinois
        s = (low * at_high - high * at_low) / (at_high - at_low)
        r = 1.0 - s
        value = r * r * r * r * (
            r * r * r * b[0] + 7.0 * r * r * s * b[1] + 21.0 * r * s * s * b[2] + 35.0 * s * s * s * b[3]
        ) + s * s * s * s * (
            35.0 * r * r * r * b[4] + 21.0 * r * r * s * b[5] + 7.0 * r * s * s * b[6] + s * s * s * b[7]
        )
        if value > 0.0:
            low, at_low = s, value
            if side == 1:
                at_high *= 0.5
            side = 1
        else:
            high, at_high = s, value
            if side == -1:
                at_low *= 0.5
            side = -1
        if high - low < 1e-9 or value == 0.0:
            break
    return high
