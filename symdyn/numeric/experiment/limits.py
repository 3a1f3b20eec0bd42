"""What each joint may do in an experiment: given, declared by the robot, or what a recording already did."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, Problem, UsageError
from symdyn.base.wording import did_you_mean
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

FIELDS = ("lower", "upper", "velocity", "acceleration", "effort", "input")


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Range, top speed, acceleration, effort and input (a motor's voltage, say) of one joint, in SI units."""

    lower: float
    upper: float
    velocity: float
    acceleration: float = math.inf
    effort: float = math.inf
    input: float = math.inf


@dataclass(frozen=True, slots=True)
class Limits:
    """One entry per joint; ``assumed`` says in words what nobody gave, and where it was taken from."""

    joints: tuple[JointLimits, ...]
    assumed: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Visited:
    """What a recording did, each (n,): the limits where nobody gives any."""

    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    effort: Array


def visited(q: Array, qd: Array, qdd: Array, tau: Array) -> Visited:
    """Extremes of a motion (N, n each); of the derivatives 99.5 % quantiles, since noise has extremes of its own."""
    speed, acceleration = (np.quantile(np.abs(values), 0.995, axis=0) for values in (qd, qdd))
    return Visited(q.min(axis=0), q.max(axis=0), speed, acceleration, np.abs(tau).max(axis=0))


def experiment_limits(robot: Robot, given: Mapping[str, Mapping[str, float]], seen: Visited | None = None) -> Limits:
    """Limits of every joint: those ``given``, else the robot's own, else what was visited.

    Acceleration and effort may stay unlimited where an effort or acceleration limits the motion.
    Raises UsageError (SD330) for unknown names and limits that are none, InputError (SD331) where nothing tells
    a joint's range, speed, or acceleration and effort.
    """
    check_names(given, robot)
    found, assumed, missing = [], [], []
    for i, joint in enumerate(robot.joints):
        own = joint.limits
        known = {} if own is None else {f: v for f in FIELDS if (v := getattr(own, f, None)) is not None}
        known |= given.get(joint.name, {})
        if seen is not None:
            needed = ["lower", "upper", "velocity"]
            needed += ["acceleration", "effort"] if not {"acceleration", "effort"} & set(known) else []
            taken = [f for f in needed if f not in known]
            known |= {f: float(getattr(seen, f)[i]) for f in taken}
            if taken:
                assumed.append(f"{', '.join(taken)} of {joint.name}")
        lacking = [f for f in ("lower", "upper", "velocity") if f not in known]
        lacking += ["acceleration or effort"] if not {"acceleration", "effort"} & set(known) else []
        if lacking:
            missing.append(f"{', '.join(lacking)} of {joint.name}")
            continue
        limits = JointLimits(**known)
        sizes = (limits.velocity, limits.acceleration, limits.effort, limits.input)
        if not (limits.lower < limits.upper and min(sizes) > 0):
            raise UsageError(Problem("SD330", f"the limits of `{joint.name}` leave no motion: {limits}"))
        found.append(limits)
    if missing:
        hint = (
            "give them with --limits JOINT:lower=..,upper=..,velocity=..,effort=.. or in the model (limits of a joint)"
        )
        raise InputError(Problem("SD331", f"nothing limits the {'; '.join(missing)}", robot.where, hint))
    told = f"what the recording already visited stands for the {'; '.join(assumed)}" if assumed else ""
    return Limits(tuple(found), told)


def check_names(given: Mapping[str, object], robot: Robot) -> None:
    """Raises UsageError (SD330) for limits of a joint that the robot does not have."""
    names = [joint.name for joint in robot.joints]
    for name in given:
        if name not in names:
            raise UsageError(Problem("SD330", f"--limits: no joint `{name}`", hint=did_you_mean(name, names, "joints")))


def read_limits(texts: Sequence[str]) -> dict[str, dict[str, float]]:
    """``elbow:lower=-1,upper=1,velocity=2,effort=5`` (SI units) by joint. Raises UsageError (SD330)."""
    found: dict[str, dict[str, float]] = {}
    for text in texts:
        joint, _, rest = text.partition(":")
        for item in rest.split(","):
            name, _, number = item.partition("=")
            try:
                value = float(number)
            except ValueError:
                value = math.nan
            if name.strip() not in FIELDS or math.isnan(value):
                hint = f"such as elbow:lower=-1,upper=1,velocity=2,effort=5; known: {', '.join(FIELDS)}"
                raise UsageError(Problem("SD330", f"--limits {text}: cannot read `{item}`", hint=hint))
            found.setdefault(joint, {})[name.strip()] = value
    return found


def widened(limits: Limits, what: str, factor: float) -> Limits:
    """The same with more ``what`` (travel, speed or effort) of every joint."""

    def wider(joint: JointLimits) -> JointLimits:
        if what == "travel":
            middle, half = (joint.lower + joint.upper) / 2, (joint.upper - joint.lower) / 2
            return replace(joint, lower=middle - factor * half, upper=middle + factor * half)
        if what == "speed":
            return replace(joint, velocity=factor * joint.velocity)
        return replace(joint, effort=factor * joint.effort, acceleration=factor * joint.acceleration)

    return Limits(tuple(wider(joint) for joint in limits.joints), limits.assumed)
