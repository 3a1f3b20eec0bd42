"""What sensors do to a channel: clipping at the end of their range, steps of quantisation, lateness."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import interpolate

from symdyn.base.errors import Problem, Where
from symdyn.numeric.recording_time import Samples, Segments
from symdyn.numeric.regression import fit_linear
from symdyn.spec.records import Channel, Quantity

CLIPPED, CLIPPED_BADLY = 0.002, 0.05  # share of samples: worth a warning; too many to conclude anything
PLATEAU = 4  # samples in a row at the very end of the range, and
LONGER = 3.0  # so many times longer than values repeat elsewhere
FEWEST_LEVELS = 50  # a channel of fewer switches between levels, and does so by intention
COARSE = 0.01  # noise of quantisation as a share of the channel's spread that is worth a warning
IDLE = 0.5  # noise of quantisation from which a channel just stands still
LATE_STEPS = 1.0  # samples by which two channels may be apart without a warning
CERTAIN = 4.0  # standard errors
ALIKE = 0.8  # correlation of two channels that measure the same
ITERATIONS = 20
LONG_ENOUGH = 50_000  # samples, to tell a skew


@dataclass(frozen=True, slots=True)
class Skew:
    """By how much one signal is late against another, in s, with its standard error."""

    delay: float
    se: float


def check_sensors(
    time: Samples, segments: Segments, measured: Sequence[tuple[Channel, Samples]], places: Mapping[Channel, Where]
) -> tuple[list[Problem], list[Problem]]:
    """Errors and warnings: SD524 clipped, SD525 coarsely quantised, SD528 velocity late against position."""
    errors: list[Problem] = []
    warnings: list[Problem] = []
    step = float(np.median(np.diff(time)))
    for channel, values in measured:
        share, level = clipped(values)
        if share > CLIPPED and channel.quantity is not Quantity.POSITION:
            message = (
                f"'{channel.column}' stands at the end of its range ({level:.6g}) in {100 * share:.1f} % of samples"
            )
            hint = "widen the range of the sensor, or move less; what is cut off cannot be told from missing physics"
            if channel.quantity is Quantity.EFFORT:
                hint += "; a command at the drive's own limit is no measurement: map it as the voltage of an actuator"
            # A voltage at its limit is what the machine was given; a measurement there is not what it was.
            bad = share > CLIPPED_BADLY and channel.quantity in (Quantity.EFFORT, Quantity.CURRENT)
            (errors if bad else warnings).append(Problem("SD524", message, places[channel], hint))
        noise, spread = quantisation_noise(values), float(np.std(values))
        if IDLE * spread > noise > COARSE * spread:
            message = f"'{channel.column}' has steps of {noise * math.sqrt(12.0):.4g}, a noise of {noise:.2g}"
            message += f" or {100 * noise / spread:.1f} % of its spread"
            warnings.append(Problem("SD525", message, places[channel], "nothing smaller can be told from this channel"))
    positions = {(c.joint, c.side): (c, values) for c, values in measured if c.quantity is Quantity.POSITION}
    for channel, values in measured:
        if channel.quantity is Quantity.VELOCITY and (channel.joint, channel.side) in positions:
            reference, position = positions[channel.joint, channel.side]
            longest = max(segments, key=lambda part: part.stop - part.start)
            part = slice(longest.start, min(longest.stop, longest.start + LONG_ENOUGH))
            found = skew(np.gradient(position[part], time[part]), values[part], step)
            if found is not None and abs(found.delay) > max(LATE_STEPS * step, CERTAIN * found.se):
                way = "late" if found.delay > 0 else "early"
                message = f"velocity '{channel.column}' is {abs(found.delay):.3g} +- {found.se:.1g} s {way}"
                message += f" against position '{reference.column}'"
                hint = "a filter or another clock; such a skew looks like compliance"
                warnings.append(Problem("SD528", message, places[channel], hint))
    return errors, warnings


def clipped(values: Samples) -> tuple[float, float]:
    """(share of samples in plateaus at the largest or smallest value, that value), the worse of the two ends.

    A plateau is a run of equal values far longer than values repeat elsewhere. A signal of few levels
    is switched, and one that mostly stands is idle; neither is clipped.
    """
    starts = np.concatenate(([0], np.flatnonzero(np.diff(values) != 0.0) + 1))
    lengths = np.diff(np.concatenate((starts, [len(values)])))
    levels = values[starts]
    worst = (0.0, float(values[0]))
    if len(np.unique(levels)) < FEWEST_LEVELS:
        return worst
    inner = lengths[(levels < values.max()) & (levels > values.min())]
    usual = float(np.quantile(inner, 0.99))
    median = float(np.median(values))
    for end in (float(values.max()), float(values.min())):
        if end == median:
            continue
        runs = lengths[(levels == end) & (lengths >= max(PLATEAU, LONGER * usual))]
        worst = max(worst, (float(np.sum(runs)) / len(values), end))
    return worst


def quantisation_noise(values: Samples) -> float:
    """Standard deviation of rounding to the steps that the values lie on, step / sqrt(12); 0 where there are none."""
    found = steps_of(values)
    return 0.0 if found is None else found[0] / math.sqrt(12.0)


def steps_of(values: Samples) -> tuple[float, float] | None:
    """The steps that values lie on, with their standard error; None where they lie on none."""
    levels = np.unique(values)
    gaps = np.diff(levels)
    apart = gaps > 1e-9 * max(float(np.ptp(values)), 1e-300)  # less is the rounding of a unit's factor
    gaps, levels = gaps[apart], levels[1:][apart]
    if len(gaps) < 2:
        return None
    step = float(np.median(gaps[gaps < 1.5 * gaps.min()]))
    multiples = gaps / step
    on_grid = np.abs(multiples - np.round(multiples)) < 0.05
    if np.mean(on_grid) <= 0.95:
        return None
    counts = np.cumsum(np.round(multiples))
    if len(counts) < FEWEST_LEVELS or not np.all(on_grid):
        return step, step / counts[-1]
    off = levels - levels.mean()
    counts = counts - counts.mean()
    slope = float(counts @ off / (counts @ counts))
    most = float(np.max(np.abs(off - slope * counts)))  # digits that a file left out repeat: errors may go together
    return slope, most / math.sqrt(3.0) * float(np.sum(np.abs(counts)) / (counts @ counts))


def skew(early: Samples, late: Samples, step: float) -> Skew | None:
    """Lateness of ``late`` against ``early``, both (K,) and alike: where a moved ``late`` leaves least of ``early``.

    Gauss-Newton from the lag of the largest correlation; the standard error allows for correlated
    residuals. None where the two have little in common.
    """
    early, late = early - early.mean(), late - late.mean()
    count = len(early)
    size = 2 ** math.ceil(math.log2(2 * count))
    correlation = np.fft.irfft(np.fft.rfft(late, size) * np.conj(np.fft.rfft(early, size)), size)
    reach = count // 8
    lags = np.concatenate((correlation[: reach + 1], correlation[-reach:]))
    common = float(lags.max(initial=0.0)) / max(float(np.linalg.norm(early) * np.linalg.norm(late)), 1e-300)
    if common < ALIKE or reach < 2:
        return None
    lag = int(np.argmax(lags))
    delay = float(lag if lag <= reach else lag - len(lags)) * step
    grid = step * np.arange(count)
    curve = interpolate.CubicSpline(grid, late)
    margin = reach + 1
    inside = slice(margin, count - margin)
    for _ in range(ITERATIONS):
        moved = grid[inside] + delay
        columns = np.stack([curve(moved), curve(moved, 1)], axis=-1)[:, None, :]
        fitted = fit_linear(columns, early[inside, None])
        move = float(fitted.estimate[1] / fitted.estimate[0])
        delay = float(np.clip(delay + move, -reach * step, reach * step))
        if abs(move) < 1e-3 * step:
            break
    return Skew(delay, float(fitted.standard_error[1] / abs(fitted.estimate[0])))
