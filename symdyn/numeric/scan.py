"""Search of shape parameters: characteristic speeds, distances and angle orders, found and not given."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.observation import Observation
from symdyn.numeric.workbench import Workbench
from symdyn.spec.effect_schema import ParameterSchema, Scan

Array = NDArray[np.float64]

SPEEDS = 24  # grid points over the speeds that occur
DISTANCES = 16  # over the distances that are travelled
ANGLES = 24  # of a turn
FREQUENCIES = 48  # over those that a band can tell
LOWEST, HIGHEST = 0.03, 3.0  # of the band's edge: slower is in no recording twice, quicker is rigid
SEVERAL = (1.0, 0.5, 0.4, 0.25)  # of those numbers, for an effect with one, two, three, more shape parameters
SLOPE_STEP = 1e-4  # of a shape value
STEEPEST = 0.05  # of the top speed: a curve that turns over below it is a jump
STRAIGHTEST = 1.5  # of the top speed: one that turns over above it departs from a line by less than an eighth
SHORTEST = 1e-3  # of the travel: less is not told from a jump
GROWTHS = 8  # grid points over distances within which something grows by itself
GROWN = (0.25, 2.0)  # of the travel: fifty-fold along it, or by half
WAVES = 2.0  # that the travel must hold: what does not repeat cannot be called periodic
FINENESS = 2.0  # orders tried per one that the travel can tell from its neighbours
MANY = 50_000  # orders at most: a joint that only trembles would allow no end of them
POSITIVE = frozenset(Scan) - {Scan.ANGLE, Scan.VALUES}  # scanned by ratios, and never zero
LEAST = 1e-12  # squared speed of a joint that stands: it shows no heat, and no scan may end at nothing
ANEW = 64  # waves after which one is evaluated, so that rounding does not grow
PEAKS = 6  # orders of a periodogram that are looked at closely


def axes(candidate: Candidate, joint: int, bench: Workbench, waves: float = WAVES) -> list[list[float]]:
    """Values of each shape parameter to try, rising; fewer of each where there are several. ``waves``: see orders."""
    seen = bench.observation
    share = SEVERAL[min(len(candidate.shapes), len(SEVERAL)) - 1]
    return [_axis(schema, seen, joint, bench.edge, share, waves) for schema in candidate.shapes]


def _axis(
    schema: ParameterSchema, seen: Observation, joint: int, edge: float, share: float, waves: float
) -> list[float]:
    top = float(np.quantile(np.abs(seen.qd[:, joint]), 0.99))
    travel = max(float(np.ptp(seen.q[:, joint])), 1e-12)
    match schema.scan:
        case Scan.SPEED:
            values = np.geomspace(top / 200.0, top, round(share * SPEEDS)) if top > 0 else np.ones(1)
        case Scan.TURNOVER:
            values = np.geomspace(STEEPEST * top, STRAIGHTEST * top, round(share * SPEEDS)) if top > 0 else np.ones(1)
        case Scan.SLOWNESS:
            values = np.array([0.1, 1.0]) / top if top > 0 else np.ones(1)
        case Scan.FREQUENCY:
            values = 2.0 * np.pi * edge * np.geomspace(LOWEST, HIGHEST, round(share * FREQUENCIES))
        case Scan.ANGLE_ORDER:
            values = orders(seen, joint, edge, waves)
        case Scan.ANGLE:
            values = np.linspace(-np.pi, np.pi, round(share * ANGLES) + 1)[1:]
        case Scan.GROWTH:
            values = travel * np.geomspace(*GROWN, round(share * GROWTHS))
        case Scan.VALUES | Scan.DAMPING:
            values = np.array(schema.tried)
        case Scan.HEAT:
            summed = max(float(np.sum(seen.qd[:, joint] ** 2)), LEAST) * seen.sample_time
            values = summed / np.array(schema.tried[::-1])
        case Scan.HEATING:
            values = np.array(schema.tried) / max(float(np.mean(seen.qd[:, joint] ** 2)), LEAST)
        case _:
            values = np.geomspace(SHORTEST * travel, 0.5 * travel, round(share * DISTANCES))
            values = 1.0 / values[::-1] if schema.scan is Scan.STEEPNESS else values
    return [float(v) for v in values]


def grid(candidate: Candidate, joint: int, bench: Workbench, waves: float = WAVES) -> list[tuple[float, ...]]:
    """Values of the shape parameters to try; one empty tuple for effects without any."""
    return list(product(*axes(candidate, joint, bench, waves)))


def room(schema: ParameterSchema, axis: Sequence[float], middle: float) -> tuple[float, float]:
    """Between which a fit may move a shape parameter that the scan found at ``middle``.

    Within the scan, and not much beyond the neighbours on its grid; of an order, down to one whole wave.
    """
    step = max(b / a if schema.scan in POSITIVE else b - a for a, b in pairwise((*axis[:1], *axis)))
    if schema.scan is Scan.ANGLE:
        return middle - 2.0 * step, middle + 2.0 * step
    low, high = axis[0], axis[-1]
    if schema.scan not in POSITIVE:
        return low, high
    factor = max(2.0, step)
    low /= WAVES if schema.scan is Scan.ANGLE_ORDER else 1.0
    return max(low, middle / factor), min(high, middle * factor)


def nudge(schema: ParameterSchema, value: float) -> float:
    """A small change of a shape parameter, for a slope."""
    return SLOPE_STEP * (abs(value) if schema.scan in POSITIVE else max(abs(value), 1.0, *schema.tried))


def orders(seen: Observation, joint: int, edge: float, waves: float = WAVES) -> Array:
    """Waves per turn that a recording can show: from ``waves`` in the travel to what passes below the band's edge at
    half of the samples. They are as fine as the travel can tell apart.
    """
    usual = float(np.median(np.abs(seen.qd[:, joint])))
    highest = 2.0 * np.pi * edge / max(usual, 1e-9)
    # Two readings of the encoder, at least, for each wave.
    steps = np.abs(np.diff(seen.q[:, joint]))
    moving = steps[steps > 0]
    if len(moving):
        highest = min(highest, np.pi / max(float(np.median(moving)), 1e-12))
    travel = float(np.ptp(seen.q[:, joint])) / (2.0 * np.pi)
    lowest = max(1.0, waves / max(travel, 1e-9))
    step = 1.0 / (FINENESS * max(travel, 1.0 / FINENESS))
    return np.arange(np.ceil(lowest), min(max(highest, lowest + 1.0), lowest + MANY * step), step)


def periodogram(left: Array, angle: Array, speed: Array, tried: Array, edge: float) -> Array:
    """Power of ``left`` (K,) at each order of the angle (K,) in ``tried``, per sample that shows it.

    A sample counts where the order passes more slowly than the band's edge. Orders rise by equal steps: each wave is
    the one before, turned by a step.
    """
    power = np.empty(len(tried))
    slowest = np.argsort(np.abs(speed), kind="stable")
    left, angle, speed = left[slowest], angle[slowest], np.abs(speed[slowest])
    shown = np.searchsorted(speed, 2.0 * np.pi * edge / tried)
    turned = np.exp(-1j * (tried[-1] - tried[0]) / max(len(tried) - 1, 1) * angle)
    wave = turned
    for i, (order, slow) in enumerate(zip(tried, shown, strict=True)):
        wave = wave[:slow] * turned[:slow] if i % ANEW else np.exp(-1j * order * angle[:slow])
        power[i] = np.abs(left[:slow] @ wave) ** 2 / max(int(slow), 1)
    return power


def screened(
    candidate: Candidate, values: list[tuple[float, ...]], left: Array, joint: int, bench: Workbench
) -> list[tuple[float, ...]]:
    """Of many orders of an angle, those at the peaks of a periodogram of ``left`` (K,); everything of other scans.

    Orders of fewer than two waves are all kept: the model's own gravity, beside which they stand, moves their peaks.
    """
    if not candidate.repeats:
        return values
    angle, speed = (bench.bring(a[:, [joint]])[:, 0] for a in (bench.observation.q, bench.observation.qd))
    power = periodogram(left, angle, speed, np.array([v[0] for v in values]), bench.edge)
    few = [v for v in values if v[0] * float(np.ptp(bench.observation.q[:, joint])) < 2.0 * np.pi * WAVES]
    return list(dict.fromkeys((*few, *(values[i] for i in peaks(power)))))


def peaks(power: Array) -> list[int]:
    """The highest local maxima, best first."""
    padded = np.concatenate([[-np.inf], power, [-np.inf]])
    top = np.flatnonzero((padded[1:-1] >= padded[:-2]) & (padded[1:-1] >= padded[2:]))
    return [int(i) for i in top[np.argsort(-power[top], kind="stable")][:PEAKS]]
