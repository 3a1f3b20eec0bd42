"""Whether what is left has structure: it follows the motion, is slow where noise is even, or more than all noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy import signal, stats

from symdyn.numeric.beyond_noise import Beyond
from symdyn.numeric.findings import Remaining
from symdyn.numeric.regression import encompassing

Array = NDArray[np.float64]

BINS = 16  # equally filled bins of one variable: any shape, no assumption on it
BINS_OF_PAIR = 8  # of each of two variables
FINE_BINS = 128  # of one variable again, where those tell nothing: for what has many waves, or is at one spot
LEVEL = 0.01
SHARE = 0.1  # structure worth naming: a tenth of what is left
LEAST_SHARE = 0.02  # of the variance of its size, where that is asked
SLOW_SHARE = 0.5  # without any variable to name, half of it

Data = tuple[Array, Array]  # residual (K, n) and variables (K, v)


def leftover(
    training: Data,
    heldout: Data,
    names: Sequence[str],
    errors: Mapping[str, float],
    per_band: float,
    floor: Array | None = None,
    known: float = 1.0,
    beyond: Sequence[Beyond] = (),
) -> Remaining:
    """Learn the training residual as a free-form function of the motion; see what that predicts held out.

    ``names`` are those of the v columns, ``errors`` of the n joints, with the held-out error of each, relative to its
    effort. Every joint's equation is asked by itself: in an arm of six the noise of five would drown what the sixth
    lacks.
    One variable at a time, and pairs of them where no single one tells: a curve or surface that predicts the
    residual of another recording is structure. Its joint, its share of the error's power, and the variables are
    reported. What no variable tells may still be no noise, and so may the rest beside one that tells a little:
    ``per_band`` samples per period of the band's edge, its spectrum is asked. ``floor`` (n,) is the root mean square
    that the sensors' noise alone has in the band, where that is known from outside the band. ``known`` is the part of
    the band in which the motion of every joint is seen: beyond, residuals lack what it does, and its noise.
    Last, ``beyond`` says of each joint what is more than noise, though it is neither: quick, and like no function.
    """
    slow = _slowest(heldout[0], errors, per_band, np.zeros(len(errors)) if floor is None else floor, known)
    loud = _loudest(training, heldout, beyond, errors)
    single = [(j,) for j in range(len(names))]
    pairs = list(combinations(range(len(names)), 2))
    told = []
    for subsets, bins in ((single, BINS), (pairs, BINS_OF_PAIR), (single, FINE_BINS)):
        follows = _best(training, heldout, subsets, bins)
        told.append(_at(follows, errors, " and ".join(names[j] for j in follows.variables) or None))
        if told[-1].structured:
            return _beside(told[-1], slow, loud)
    return _beside(slow, loud) if slow else loud or told[0]


def variables(joints: Sequence[str]) -> list[str]:
    """Names of the columns of a workbench's motion."""
    return [f"{what} of {joint}" for what in ("position", "speed", "acceleration") for joint in joints]


@dataclass(frozen=True, slots=True)
class _Structure:
    """What is left at one joint: which variables it follows, and the share of that joint's power that does."""

    joint: int
    variables: tuple[int, ...]
    share: float
    p_value: float


def _beside(what: Remaining, *others: Remaining | None) -> Remaining:
    """The same, with what else is slow, or more than noise."""
    for other in others:
        if other is not None:
            most = max(what.slow, other.slow), max(what.beyond_noise, other.beyond_noise), max(what.size, other.size)
            what = replace(what, slow=most[0], beyond_noise=most[1], size=most[2])
    return what


def _loudest(training: Data, heldout: Data, beyond: Sequence[Beyond], errors: Mapping[str, float]) -> Remaining | None:
    """The joint at which most is left beyond noise, and is not as even as the noise of a sensor that filters may be.

    That noise is the same wherever the machine is, and no frequency stands out of it.
    """
    powers = np.square(list(errors.values())).tolist()
    loud = [
        j
        for j, of in enumerate(beyond)
        if is_loud(of, len(beyond)) and (of.line * len(beyond) < LEVEL or _comes_and_goes(training, heldout, j))
    ]
    if not loud:
        return None
    joint = max(loud, key=lambda j: beyond[j].share * powers[j])
    most = _Structure(joint, (), beyond[joint].share, min(1.0, beyond[joint].p_value * len(beyond)))
    found = _at(most, errors, None)
    return replace(found, beyond_noise=found.share)


def is_loud(of: Beyond, joints: int) -> bool:
    """Whether what is left at one of so many joints is more than the noise that is accounted for."""
    return of.share > SHARE and of.p_value * joints < LEVEL


def _comes_and_goes(training: Data, heldout: Data, joint: int) -> bool:
    """Whether the size of a residual follows the motion, though it may not follow it itself."""
    (r_train, x_train), (r_held, x_held) = training, heldout
    mean = float(np.mean(r_train[:, joint] ** 2)) + 1e-300
    sizes = [r[:, [joint]] ** 2 / mean - 1.0 for r in (r_train, r_held)]
    subsets = [(j,) for j in range(x_train.shape[1])]
    return _best((sizes[0], x_train), (sizes[1], x_held), subsets, BINS).share > LEAST_SHARE


def _at(found: _Structure, errors: Mapping[str, float], variable: str | None) -> Remaining:
    place, there = list(errors.items())[found.joint]
    powers = np.square(list(errors.values()))
    share = found.share * there**2 / max(float(powers.sum()), 1e-300)
    size = float(np.sqrt(found.share)) * there
    known = place if found.share > 0.0 else None
    return Remaining(float(np.sqrt(powers.mean())), found.share > SHARE, share, variable, found.p_value, size, known)


def _slowest(
    residual: Array, errors: Mapping[str, float], per_band: float, floor: Array, known: float
) -> Remaining | None:
    """The joint whose residual is slow for the most part, where one is."""
    slow = [slow_share(residual[:, [j]], per_band, floor[[j]], known) for j in range(len(errors))]
    joint = max(range(len(slow)), key=lambda j: slow[j])
    share, p_value = slow[joint][0], min(1.0, slow[joint][1] * len(slow))
    if share <= SLOW_SHARE or p_value >= LEVEL:
        return None
    found = _at(_Structure(joint, (), share, p_value), errors, None)
    return replace(found, slow=found.share)


def slow_share(residual: Array, per_band: float, floor: Array | None = None, known: float = 1.0) -> tuple[float, float]:
    """Share of the power that the lower half of the band has above the level of its upper half, and its p-value.

    Sensor noise is even over the band, or grows with frequency where positions were differentiated;
    a mismatch lives in the lower half of a band that was chosen to hold it twice over. ``residual``
    (K, n) has ``per_band`` samples per period of the band's edge. Level and scatter are those of
    Welch's spectrum: each bin is chi-squared with two degrees of freedom per independent segment.
    What noise of the level ``floor`` (n,) would leave is no structure, however it is spread. Where motion is
    seen in part of the band, ``known``, that part is asked.
    """
    best = (0.0, 1.0)
    edge = min(known, 1.0)
    levels = np.zeros(residual.shape[1]) if floor is None else floor
    for column, level in zip(residual.T, levels.tolist(), strict=True):
        length = min(len(column), max(32, len(column) // 8))
        frequency, power = signal.welch(column, per_band, nperseg=length, detrend="constant")
        half = 0.5 * edge + 2.0 * frequency[1]  # a line at the middle spreads over two bins of the window
        low = power[(frequency > 0) & (frequency <= half)]
        high = power[(frequency > half) & (frequency <= 0.9 * edge)]
        if len(low) == 0 or len(high) == 0 or not high.any():
            continue
        freedom = 2.0 * len(column) / length
        p_value = float(stats.f.sf(low.mean() / high.mean(), freedom * len(low), freedom * len(high)))
        excess = float(low.sum() - high.mean() * len(low))
        share = min(excess / float(power[frequency <= 1.0].sum()), 1.0 - level**2 / float(np.mean(column**2)))
        best = max(best, (share, min(1.0, p_value * residual.shape[1])))
    return best


def _best(training: Data, heldout: Data, subsets: Sequence[tuple[int, ...]], bins: int) -> _Structure:
    """The joint and the variables that tell the largest share of its power."""
    (r_train, x_train), (r_held, x_held) = training, heldout
    size = np.sqrt(np.mean(r_train**2, axis=0)) + 1e-300
    before = r_held / size
    power = np.maximum(np.mean(before**2, axis=0), 1e-300)
    best = _Structure(0, (), 0.0, 1.0)
    for subset in subsets:
        cell_train, cell_held = np.zeros(len(x_train), dtype=int), np.zeros(len(x_held), dtype=int)
        for j in subset:
            edges = np.quantile(x_train[:, j], np.linspace(0, 1, bins + 1)[1:-1])
            cell_train = cell_train * bins + np.digitize(x_train[:, j], edges)
            cell_held = cell_held * bins + np.digitize(x_held[:, j], edges)
        after = (r_held - _means(r_train, cell_train, bins ** len(subset))[cell_held]) / size
        shares = 1.0 - np.mean(after**2, axis=0) / power
        for joint in np.flatnonzero(shares > best.share):  # significance is asked of what may be the best alone
            p_value = encompassing(before[:, [joint]], after[:, [joint]])[1] * len(subsets) * len(power)
            if p_value < LEVEL and shares[joint] > best.share:
                best = _Structure(int(joint), subset, float(shares[joint]), p_value)
    return best


def _means(residual: Array, cell: NDArray[np.int_], cells: int) -> Array:
    """Mean residual of each cell, shrunk towards zero where few samples are: (cells, n)."""
    count = np.bincount(cell, minlength=cells)
    sums = [np.bincount(cell, weights=column, minlength=cells) for column in residual.T]
    return np.stack(sums, axis=1) / (count[:, None] + 1.0)
