"""What frequency, sensitivity and reduce have in common: the linear model asked for, its band, JSON of records."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symdyn import compiler
from symdyn.base.errors import Problem, UsageError
from symdyn.base.linear_system import LinearFamily
from symdyn.base.wording import did_you_mean
from symdyn.derive.linearize import without_nonsmooth
from symdyn.faces.console import err
from symdyn.faces.model_commands import refuse_free_parameters
from symdyn.numeric.linear.cost import Cost
from symdyn.numeric.linear.modes import Mode
from symdyn.spec.records import Robot
from symdyn.spec.urdf_chain import Chain

MOST_POINTS = 1_000_000
_WIDEST = 1e5  # of the default band, highest over lowest
_RESTS = 1e-9  # of the size of the coefficients: rates below it are rounding


@dataclass(frozen=True, slots=True)
class Linear:
    """A model, its linear part at the operating point, and what was left out of it."""

    robot: Robot
    family: LinearFamily
    at: Mapping[str, float]
    left_out: tuple[str, ...]
    drift: Mapping[str, float]  # rates at the operating point that are not those of a machine at rest

    def facts(self) -> dict[str, Any]:
        return {
            "robot": self.robot.name,
            "operating_point": dict(self.at),
            "left_out": list(self.left_out),
            "drift": dict(self.drift),
        }


def open_linear(model: str, chain: Chain, at: Sequence[str], known: Sequence[str] = ()) -> Linear:
    """Read the model; ``at`` are NAME=VALUE of states and inputs.

    What was left out of the linear part takes states and inputs along; ``at`` may name those that are ``known``.

    Raises UsageError: SD304 for a parameter without a value, SD305 for a name or a value that is none.
    """
    robot = compiler.load_robot(model, chain)
    refuse_free_parameters(robot)
    smooth = without_nonsmooth(robot)
    there = {(e.type, e.at) for e in smooth.effects}
    gone = [
        f"{e.type} at {e.at}" if (e.type, e.at) not in there else f"jumps of {e.type} at {e.at}"
        for e in robot.effects
        if e not in smooth.effects
    ]
    names = compiler.linearise(smooth).nominal
    linear_names = (*names.states, *names.inputs)
    point = {k: v for k, v in values_at(at, (*linear_names, *known)).items() if k in linear_names}
    x = np.array([point.get(name, 0.0) for name in names.states])
    u = np.array([point.get(name, 0.0) for name in names.inputs])
    family = compiler.linearise(smooth, x, u)
    system = family.nominal
    limit = _RESTS * float(np.abs(np.concatenate([x, u, [1.0]])).max())
    n = len(system.coordinates)
    rates = dict(zip(system.states[n:], map(float, system.drift[n:]), strict=True))
    drift = {name: rate for name, rate in rates.items() if abs(rate) > limit}
    return Linear(robot, family, point, tuple(gone), drift)


def tell(linear: Linear) -> None:
    """On stderr: what the linear model is not."""
    if linear.left_out:
        err.print(f"linear part, without {', '.join(linear.left_out)}", markup=False)
    if linear.drift:
        rates = ", ".join(f"d {name}/dt = {rate:.4g}" for name, rate in linear.drift.items())
        err.print(
            f"the machine does not rest at this point: {rates} (SI units); --at sets states and inputs", markup=False
        )


def band_of(low: float | None, high: float | None, modes: Sequence[Mode]) -> tuple[float, float]:
    """--from and --to in Hz; by default from a tenth of the slowest mode (five decades at most) to three times the
    fastest oscillation.

    Raises UsageError (SD302) unless 0 < from < to are finite.
    """
    every = [mode.frequency for mode in modes if mode.frequency > 0]
    swinging = [mode.frequency for mode in modes if mode.pole.imag > 0] or every
    last = high if high is not None else _rounded(3.0 * max(swinging, default=10.0))
    slowest = 0.1 * min(every, default=10.0 * last / _WIDEST)
    first = low if low is not None else _rounded(max(slowest, last / _WIDEST))
    if high is None:
        last = max(last, 10 * first)
    if not (math.isfinite(first) and math.isfinite(last) and 0 < first < last):
        raise UsageError(Problem("SD302", f"--from and --to must be 0 < from < to in Hz, not {first:g} and {last:g}"))
    return first, last


def check_points(points: int) -> None:
    if not 2 <= points <= MOST_POINTS:
        raise UsageError(Problem("SD302", f"--points must be from 2 to {MOST_POINTS}"))


def mode_facts(mode: Mode) -> dict[str, Any]:
    return {
        "name": mode.name,
        "pole": [mode.pole.real, mode.pole.imag],
        "frequency": mode.frequency,
        "damping": mode.damping,
        "decay": mode.decay,
        "kinetic": dict(mode.kinetic),
        "strain": dict(mode.strain),
        "hidden": dict(mode.hidden),
        "losses": dict(mode.losses),
        "shape": {name: [z.real, z.imag] for name, z in mode.shape.items()},
    }


def cost_facts(cost: Cost) -> dict[str, Any]:
    return {
        "worst": finite(cost.worst),
        "hertz": cost.hertz,
        "decibel": finite(cost.decibel),
        "rms": finite(cost.rms),
    }


def finite(value: float) -> float | None:
    """JSON has no infinity and no NaN."""
    return float(value) if math.isfinite(value) else None


def values_at(given: Sequence[str], names: Sequence[str]) -> dict[str, float]:
    """NAME=VALUE of --at; UsageError (SD305) for a name that is not among ``names``, or a value that is none."""
    values: dict[str, float] = {}
    for item in given:
        name, _, text = item.partition("=")
        if name not in names:
            hint = did_you_mean(name, names, "states and inputs")
            raise UsageError(Problem("SD305", f"--at {item}: no such state or input", hint=hint))
        try:
            values[name] = float(text)
        except ValueError:
            values[name] = math.nan
        if not math.isfinite(values[name]):
            raise UsageError(Problem("SD305", f"--at {item}: {text!r} is no finite number"))
    return values


def _rounded(value: float) -> float:
    """To one digit."""
    return float(f"{value:.0e}")
