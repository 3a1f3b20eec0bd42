"""Fits the parameters of a model as it is, before anything is blamed on it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import fmean
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from symdyn.base.errors import InputError, Problem
from symdyn.numeric.band import analysis_band, band_of
from symdyn.numeric.candidates import bounds
from symdyn.numeric.explanation import own_parameters
from symdyn.numeric.findings import Estimate
from symdyn.numeric.fitting import Fit, fit, joint_weight, relative_error
from symdyn.numeric.known import check_separable, known_names
from symdyn.numeric.mechanics import mechanical_kernel, soft_rotors
from symdyn.numeric.observation import observe, untested_equations
from symdyn.numeric.reading import declared
from symdyn.numeric.readings import read
from symdyn.numeric.recording import Recording
from symdyn.numeric.sizes import sizes
from symdyn.numeric.too_quick import too_quick
from symdyn.numeric.torque_sensors import parts
from symdyn.numeric.workbench import Workbench
from symdyn.spec.records import Robot


@dataclass(frozen=True, slots=True)
class Identification:
    """Fitted parameters, and the relative effort error that is left in the analysis band (Hz)."""

    parameters: Mapping[str, Estimate]
    error: float
    band: float
    alarms: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        return {
            "parameters": {n: {"value": e.value, "se": e.se, "unit": e.unit} for n, e in self.parameters.items()},
            "relative_error": self.error,
            "band_hz": self.band,
            "alarms": list(self.alarms),
        }


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A model fitted to a recording: on ``bench``, with the ``weight`` (n,) of each joint."""

    bench: Workbench
    fit: Fit
    weight: NDArray[np.float64]


def identify(
    robot: Robot,
    recording: Recording,
    *,
    band: float | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Identification:
    """Inverse-dynamics least squares on one recording, standard errors by Newey and West.

    Raises InputError when the recording does not measure what inverse dynamics needs, or rotors have coordinates of
    their own (SD521).
    """
    pieces, told = parts(robot, [recording])
    found, errors, cutoff = dict[str, Estimate](), list[float](), 0.0
    for part in pieces:
        piece = part.of(robot)
        done = fitted(piece, part.seen(robot, recording), band=band, progress=progress)
        bench, kernel = done.bench, done.bench.kernel
        for n in done.fit.names:
            unit = kernel.parameter_units[bench.index[n]]
            found[n] = Estimate(float(done.fit.p[bench.index[n]]), done.fit.standard_error(n), unit)
        cutoff = max(cutoff, bench.band.cutoff if bench.band else 0.0)
        errors += [relative_error(bench.residual(done.fit.p), bench.reference) ** 2] * len(piece.joints)
        joints = [joint.name for joint in piece.joints]
        doubts = *untested_equations(bench.observation, joints), *too_quick(bench, done.fit.p, joints)
        told += map(part.named, doubts)
    return Identification(found, math.sqrt(fmean(errors)), cutoff, tuple(told))


def fitted(
    robot: Robot,
    recording: Recording,
    *,
    band: float | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Fitted:
    """The fit itself. Raises as ``identify`` does."""
    with threadpool_limits(1):  # the matrices are tall and narrow: threads would only wait for each other
        return _fitted(robot, recording, band, progress)


def _fitted(robot: Robot, recording: Recording, band: float | None, progress: Callable[[str], None]) -> Fitted:
    progress(f"deriving and compiling {robot.name}")
    if soft_rotors(robot):
        message = f"'{robot.name}' has coordinates of its own for {', '.join(soft_rotors(robot))}"
        hint = "inverse dynamics takes transmissions for rigid: fix the rotors to their joint (fixed_to_joint = true)"
        raise InputError(Problem("SD521", message, robot.where, hint))
    kernel = mechanical_kernel(robot)
    wide = Workbench(kernel, read(observe(robot, kernel, recording), declared(robot)))
    values = kernel.values
    given = known_names([recording])
    names = [n for n in own_parameters(robot, wide) if n not in given]
    seen = wide.observation
    if seen.known is not None:
        check_separable(seen.known, kernel, (seen.q, seen.qd, seen.qdd), names)
    start = fit(wide, values, names, joint_weight(wide.reference, wide.reference), bounds(robot), sizes(robot))
    chosen = analysis_band(wide.raw_residual(start.p), seen) if band is None else band_of(band, seen.rate)
    seen = read(observe(robot, kernel, recording, 5.0 * chosen.cutoff), declared(robot))
    bench = Workbench(kernel, seen, chosen)
    weight = joint_weight(bench.residual(start.p), bench.reference)
    return Fitted(bench, fit(bench, values, names, weight, bounds(robot), sizes(robot)), weight)
