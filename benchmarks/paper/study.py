"""Everything that the page needs of the one-d.o.f. drive, computed once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from benchmarks.paper.jumps import Jumps, jumps
from symdyn.base.linear_system import LinearFamily, LinearSystem
from symdyn.compiler import linearise, load_robot
from symdyn.derive.linearize import without_nonsmooth
from symdyn.numeric.linear.cost import Band
from symdyn.numeric.linear.local_sensitivity import LocalSensitivity, local_sensitivity
from symdyn.numeric.linear.modes import Mode, modes
from symdyn.numeric.linear.one_at_a_time import OneAtATime, one_at_a_time
from symdyn.numeric.linear.propose import Reduction, propose, reduced
from symdyn.numeric.linear.response import Extremum, Response, extrema, frequency_response
from symdyn.spec.records import Robot

MACHINE = "irb6-axis1"
LOW, HIGH, POINTS = 0.1, 3000.0, 601
CONTROL = Band(LOW, 100.0)  # Hz: what a position loop of such a robot can use
WHOLE = Band(LOW, HIGH)
TOLERANCE = 0.05
PRINTED_HERTZ = (16.0, 600.0, 1200.0)


@dataclass(frozen=True)
class Study:
    """The drive without its jumps (T_f and S), from motor voltage to tachometer voltage; ``jumps``: with them."""

    robot: Robot
    family: LinearFamily
    system: LinearSystem
    modes: tuple[Mode, ...]
    extrema: tuple[Extremum, ...]
    local: LocalSensitivity
    at_peaks: LocalSensitivity  # exactly there: a peak's height does not feel that its frequency moves
    varied: OneAtATime
    control: Reduction
    whole: Reduction

    @cached_property
    def jumps(self) -> Jumps:
        """Simulated when they are first asked for: compiling the simulations takes minutes."""
        return jumps()

    @property
    def swinging(self) -> tuple[Mode, ...]:
        return tuple(mode for mode in self.modes if mode.pole.imag > 0)

    @property
    def peaks(self) -> tuple[Extremum, ...]:
        return tuple(e for e in self.extrema if e.kind == "peak")

    def reduced(self) -> LinearSystem:
        """The proposal for the control band, as a model."""
        return reduced(self.family, self.control)

    def with_lost_damper(self) -> tuple[Mode, ...]:
        """Modes of the model as the paper assembles it: d_2 acts on J_3 and not back on J_2."""
        motor, drive = (len(self.system.coordinates) + self.system.coordinates.index(f"axis1.{name}")
                        for name in ("motor", "harmonic_drive"))  # fmt: skip
        f = self.system.f.copy()
        d_2 = self.family.values[self.family.index("d_2")]
        f[motor, motor] += d_2
        f[motor, drive] -= d_2
        return tuple(mode for mode in modes(replace(self.system, f=f)) if mode.pole.imag > 0)


def study() -> Study:
    robot = load_robot(MACHINE)
    family = linearise(without_nonsmooth(robot))
    system = family.nominal
    hertz = np.geomspace(LOW, HIGH, POINTS)
    found = extrema(system, LOW, HIGH)
    return Study(
        robot=robot,
        family=family,
        system=system,
        modes=modes(system),
        extrema=found,
        at_peaks=local_sensitivity(family, np.array([e.frequency for e in found if e.kind == "peak"])),
        local=local_sensitivity(family, hertz),
        varied=one_at_a_time(family, hertz),
        control=propose(family, CONTROL, TOLERANCE),
        whole=propose(family, WHOLE, TOLERANCE),
    )


def peak_change(s: Study, parameter: str, factor: float, peak: int) -> tuple[float, float] | None:
    """(frequency ratio, height in dB) by which a peak of the response moves; None where it is gone."""
    p = s.family.values.copy()
    p[s.family.index(parameter)] *= factor
    moved = [e for e in extrema(s.family.at(p), LOW, HIGH) if e.kind == "peak"]
    if len(moved) != len(s.peaks):
        return None
    before, after = s.peaks[peak], moved[peak]
    return after.frequency / before.frequency, float(20 * np.log10(after.magnitude / before.magnitude))


def largest_change(s: Study, parameter: str, low: float, high: float) -> float:
    """Largest change of |G| in dB between two frequencies when the parameter is halved or doubled."""
    hertz = s.varied.nominal.hertz
    inside = (hertz >= low) & (hertz <= high)
    found = [np.abs(s.varied.deviation(v)[inside]).max() for v in s.varied.variations if v.parameter == parameter]
    return float(max(found, default=0.0))


def first_felt(s: Study, parameter: str, decibel: float) -> float | None:
    """Lowest frequency at which halving or doubling the parameter changes |G| by that much; None: nowhere."""
    hertz = s.varied.nominal.hertz
    rows = [np.abs(s.varied.deviation(v)) >= decibel for v in s.varied.variations if v.parameter == parameter]
    felt = np.flatnonzero(np.any(rows, axis=0)) if rows else []
    return float(hertz[felt[0]]) if len(felt) else None


def cosine(s: Study, a: str, b: str, low: float, high: float) -> float:
    """Between the sensitivities of the response to two parameters over a band: 1 where they do the same."""
    hertz = s.local.response.hertz
    inside = (hertz >= low) & (hertz <= high)
    g = s.local.response_gradient[:, inside] / s.local.response.values[inside]
    x, y = g[s.family.index(a)], g[s.family.index(b)]
    return float(np.vdot(x, y).real / np.sqrt(np.vdot(x, x).real * np.vdot(y, y).real))


def ranking(s: Study) -> list[tuple[str, float]]:
    """R.m.s. of d ln|G| / d ln p over the band, largest first."""
    size = np.sqrt(np.mean(s.local.magnitude_log**2, axis=1))
    return sorted(zip(s.local.parameters, map(float, size), strict=True), key=lambda row: -row[1])


def response_of(s: Study, system: LinearSystem) -> Response:
    return frequency_response(system, s.local.response.hertz)
