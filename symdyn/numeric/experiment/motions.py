"""Motions of an experiment: slow sweeps at constant speed, then a Fourier series, from rest to rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.experiment.limits import JointLimits, Limits
from symdyn.numeric.experiment.waveforms import Three, brought_in, fourier_series, triangle

Array = NDArray[np.float64]

HARMONICS = 5  # of the Fourier series (Swevers, Ganseman, Tuekel, De Schutter, Van Brussel 1997)
FEWER = 3  # for arms with many joints: each joint's motion helps to excite the others
MOST_SWEEPS = 20.0  # to and fro
MOST_PERIODS = 8.0  # of the fundamental
EDGE = 0.9  # how near to its limits a joint's centre may lie
SLACK = 1e-3  # of each limit is left, since peaks lie between samples
LEAST_SHARE, MOST_SHARE = 0.1, 0.9  # of the time that the sweeps take


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """``time`` (N,); position, speed and acceleration (N, n) of the joints."""

    time: Array
    q: Array
    qd: Array
    qdd: Array

    def table(self, names: tuple[str, ...], units: tuple[str, ...]) -> Mapping[str, Array]:
        """Columns by name with units: ``time [s]``, ``elbow.q [rad]``, ``elbow.qd [rad/s]``, ``elbow.qdd ...``."""
        columns = {"time [s]": self.time}
        for values, order, per in ((self.q, "q", ""), (self.qd, "qd", "/s"), (self.qdd, "qdd", "/s^2")):
            for i, (name, unit) in enumerate(zip(names, units, strict=True)):
                columns[f"{name}.{order} [{unit}{per}]"] = values[:, i]
        return columns


@dataclass(frozen=True, slots=True)
class Family:
    """All motions of ``duration`` s within the limits; each is a point of the unit cube of ``size`` dimensions.

    The first coordinate is the sweeps' share of the time. Then per joint: centre, travel and rate of the sweeps,
    travel of the series, and its coefficients; last the fundamental, common to all joints. Amplitudes are cut
    to the limits of position, speed and acceleration, so that every point is a motion that the joints can do,
    but for its effort.
    """

    limits: Limits
    duration: float

    @property
    def harmonics(self) -> int:
        return HARMONICS if len(self.limits.joints) <= 2 else FEWER

    @property
    def size(self) -> int:
        return 2 + len(self.limits.joints) * (4 + 2 * self.harmonics)

    def motion(self, point: Array, count: int, scale: float = 1.0) -> Motion:
        """``count`` samples from 0 to the duration; ``scale`` shrinks all amplitudes."""
        time = np.linspace(0.0, self.duration, count)
        share = LEAST_SHARE + (MOST_SHARE - LEAST_SHARE) * point[0]
        sweeping = share * self.duration
        rest = self.duration - sweeping
        frequency = MOST_PERIODS ** point[-1] / rest
        first = time < sweeping
        signals = np.zeros((3, count, len(self.limits.joints)))
        per = 4 + 2 * self.harmonics
        for j, limits in enumerate(self.limits.joints):
            own = point[1 + j * per : 1 + (j + 1) * per]
            half = (limits.upper - limits.lower) / 2
            centre = (limits.upper + limits.lower) / 2 + EDGE * half * (2 * own[0] - 1)
            room = min(limits.upper - centre, centre - limits.lower)
            sweep = brought_in(triangle(time[first], MOST_SWEEPS ** own[2] / sweeping), time[first], sweeping)
            series = fourier_series(time[~first] - sweeping, frequency, own[4:].reshape(2, -1))
            series = brought_in(series, time[~first] - sweeping, rest)
            for part, shape, travel in ((first, sweep, own[1]), (~first, series, own[3])):
                amplitude = scale * _largest(shape, travel * room, limits)
                signals[:, part, j] = amplitude * np.stack(shape)
            signals[0, :, j] += centre
        return Motion(time, *signals)


def _largest(shape: Three, travel: float, limits: JointLimits) -> float:
    """The amplitude at which the travel, or else speed or acceleration, is reached."""
    peaks = [max(float(np.abs(part).max(initial=0.0)), 1e-12) for part in shape]
    allowed = (travel / peaks[0], limits.velocity / peaks[1], limits.acceleration / peaks[2])
    return (1.0 - SLACK) * min(allowed)
