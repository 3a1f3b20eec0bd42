"""What a diagnosis says: verdict, findings, where, fit before and after, what is left. Plain data, JSON-ready."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import Problem
from symdyn.base.json_text import plain
from symdyn.spec.records import Robot

Array = NDArray[np.float64]
Json = dict[str, Any]


DIGITS = 8  # of fitted values in a specification


class Verdict(StrEnum):
    COMPLETE = "complete"
    MISSING_PHYSICS = "missing_physics"
    AMBIGUOUS = "ambiguous"
    UNEXPLAINED = "unexplained"
    BAD_RECORDING = "bad_recording"


@dataclass(frozen=True, slots=True)
class Estimate:
    """A fitted number; ``se`` is its standard error, None where the recording does not tell it alone."""

    value: float
    se: float | None
    unit: str

    @property
    def written(self) -> str:
        """As a specification holds it; digits far below any standard error are left out."""
        return f"{self.value:.{DIGITS}g} {'' if self.unit == '1' else self.unit}".strip()

    def to_json(self) -> Json:
        return {"value": self.value, "se": self.se, "unit": self.unit}


@dataclass(frozen=True, slots=True)
class Rival:
    """Another effect that explains the same: ``p_value`` of "the finding explains no better"."""

    effect: str
    place: str
    p_value: float

    def to_json(self) -> Json:
        return {"effect": self.effect, "place": self.place, "p_value": self.p_value}


@dataclass(frozen=True, slots=True)
class Alternative:
    """Another effect that would have earned the same step, and the relative held-out error it would have left."""

    effect: str
    place: str
    heldout: float

    def to_json(self) -> Json:
        return {"effect": self.effect, "place": self.place, "heldout": self.heldout}


@dataclass(frozen=True, slots=True)
class SameLaw:
    """The law that a finding is together with ``beside``, other effects at its place: another name, and no rival."""

    effect: str
    place: str
    beside: tuple[str, ...]
    parameters: Mapping[str, Estimate]

    def to_json(self) -> Json:
        return {
            "effect": self.effect,
            "place": self.place,
            "p_value": 1.0,
            "same_law": True,
            "beside": list(self.beside),
            "parameters": estimates_json(self.parameters),
        }


@dataclass(frozen=True, slots=True)
class Finding:
    """A missing effect. Errors are relative, on held-out data, before and after it was added.

    ``evidence`` is the gain of the held-out log-likelihood in nats, correlated residuals allowed for;
    ``group`` names the places where the same effect would do as well, its own included (empty: its own alone);
    ``elsewhere`` holds its parameters at those others of them that a gear, or a shaft, joins to its own.
    """

    effect: str
    title: str
    place: str
    parameters: Mapping[str, Estimate]
    heldout_before: float
    heldout_after: float
    p_value: float  # of "no gain" on the held-out data
    rivals: tuple[Rival, ...]
    alternatives: tuple[Alternative, ...] = ()
    group: tuple[str, ...] = ()
    evidence: float = 0.0
    elsewhere: Mapping[str, Mapping[str, Estimate]] = field(default_factory=dict)
    number: int = 1  # the how manieth of its kind at its place
    same_as: tuple[SameLaw, ...] = ()  # no motion tells these from it: they are no rivals but names

    @property
    def key(self) -> tuple[str, str, int]:
        return self.effect, self.place, self.number

    @property
    def heldout_gain(self) -> float:
        """By how much the relative held-out error fell."""
        return self.heldout_before - self.heldout_after

    @property
    def others(self) -> tuple[tuple[str, str], ...]:
        """What the recording does not tell it from: the likeliest rival first, then itself elsewhere."""
        rivals = tuple((r.effect, r.place) for r in sorted(self.rivals, key=lambda r: -r.p_value))
        return rivals + tuple((self.effect, place) for place in self.group if place != self.place)

    def to_json(self) -> Json:
        return {
            "effect": self.effect,
            "place": self.place,
            "group": list(self.group or (self.place,)),
            "parameters": estimates_json(self.parameters),
            "elsewhere": {place: estimates_json(values) for place, values in self.elsewhere.items()},
            "evidence": self.evidence,
            "heldout_gain": self.heldout_gain,
            "heldout_before": self.heldout_before,
            "heldout_after": self.heldout_after,
            "p_value": self.p_value,
            "rivals": [*(rival.to_json() for rival in self.rivals), *(same.to_json() for same in self.same_as)],
            "alternatives": [other.to_json() for other in self.alternatives],
        }


@dataclass(frozen=True, slots=True)
class Located:
    """A place where the model as given does not account for the recording, and when it does not.

    ``evidence`` in nats is how much a free-form force there would raise the held-out log-likelihood, or what was found
    there, if no force of a free form told of it;
    ``when`` says what the mismatch follows, strongest first: "sign of speed", "low speed", "reversal" ...
    """

    place: str
    group: tuple[str, ...]  # places that the recording cannot tell apart, its own included
    evidence: float
    when: tuple[str, ...] = ()

    def to_json(self) -> Json:
        return {
            "place": self.place,
            "group": list(self.group or (self.place,)),
            "evidence": self.evidence,
            "when": list(self.when),
        }


@dataclass(frozen=True, slots=True)
class Errors:
    """Relative error of what is predicted: size of the residual over that of what was measured."""

    training: float
    heldout: float

    def to_json(self) -> Json:
        return {"training": self.training, "heldout": self.heldout}


@dataclass(frozen=True, slots=True)
class NoiseFloor:
    """The relative error that the sensors' noise alone would leave, over all and at each joint (or channel)."""

    errors: Errors
    per_joint: Mapping[str, Errors] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Remaining:
    """What no known effect explains."""

    heldout: float  # relative error that is left
    structured: bool  # whether it still follows the motion
    share: float  # part of the held-out error's power that does
    variable: str | None  # what it follows most: "position of elbow"
    p_value: float
    size: float  # of the structured part, relative to the effort (or the motion) where it is
    place: str | None = None  # whose equation it is left in; None where no single one tells
    slow: float = 0.0  # part of that power that is slow where noise would be even, whatever it follows
    beyond_noise: float = 0.0  # part of that power that sensors and sampling do not account for, whatever it follows

    @property
    def unlike_noise(self) -> float:
        """Part of the power that is no noise, by whatever shows it."""
        return max(self.share, self.slow, self.beyond_noise)

    def to_json(self) -> Json:
        return {
            "heldout": self.heldout,
            "structured": self.structured,
            "share": self.share,
            "slow": self.slow,
            "beyond_noise": self.beyond_noise,
            "variable": self.variable,
            "p_value": self.p_value,
            "place": self.place,
        }


@dataclass(frozen=True, slots=True)
class NextExperiment:
    """A motion that would separate what these recordings cannot."""

    between: tuple[tuple[str, str], ...]  # (effect, place) of each hypothesis, the best first
    separation: float  # expected evidence of the better one over the other, in nats
    file: str | None  # of the trajectory, where one was written
    why: str  # one sentence for people

    def to_json(self) -> Json:
        between = [{"effect": effect, "place": place} for effect, place in self.between]
        return {"between": between, "separation": self.separation, "file": self.file, "why": self.why}


@dataclass(frozen=True, slots=True, eq=False)
class MissingForce:
    """What resists at a place beyond the model, as a filter estimates it on held-out data, each (K,).

    No law was fitted to it. ``x`` is the displacement that it works along (``what``: a position, or a shaft's twist),
    ``v`` its rate.
    """

    place: str
    what: str
    x: Array
    v: Array
    before: Array  # beyond the model as given
    after: Array  # beyond the diagnosed model
    units: tuple[str, str]  # of displacement, and force


@dataclass(frozen=True, slots=True, eq=False)
class Traces:
    """For plots, on held-out data in the analysis band, each (K, n)."""

    time: Array
    q: Array
    qd: Array
    effort: Array
    before: Array  # prediction of the model as given, refitted
    after: Array
    joints: tuple[str, ...]
    effort_units: tuple[str, ...]
    noise: Array | None = None  # (n,) amplitude density of the sensors' noise per root hertz, where it is known
    missing: tuple[MissingForce, ...] = ()  # where a filter followed the machine


@dataclass(frozen=True, slots=True, eq=False)
class Diagnosis:
    verdict: Verdict
    robot: Robot  # as given
    diagnosed: Robot  # with the effects found and the parameters fitted
    findings: tuple[Finding, ...]
    model: Mapping[str, Estimate]  # the model's own parameters, fitted together with the findings
    before: Errors
    after: Errors
    per_joint_before: Mapping[str, Errors]
    per_joint: Mapping[str, Errors]  # after
    remaining: Remaining
    alarms: tuple[str, ...]
    band: float  # Hz
    training: str
    heldout: str
    traces: Traces = field(repr=False)
    located: tuple[Located, ...] = ()  # best first
    noise_floor: NoiseFloor | None = None  # None: the recording does not tell it
    next_experiment: NextExperiment | None = None
    judged: str = "effort"  # what errors are relative to, for people

    def to_json(self) -> Json:
        """The facts for other programs; the same words as in the report."""
        floor = self.noise_floor
        unknown = {"training": None, "heldout": None}
        at_joint = floor.per_joint if floor else {}
        facts = {
            "verdict": str(self.verdict),
            "robot": self.robot.name,
            "findings": [finding.to_json() for finding in self.findings],
            "located": [located.to_json() for located in self.located],
            "model": estimates_json(self.model),
            "fit": {
                "before": self.before.to_json(),
                "after": self.after.to_json(),
                "noise_floor": floor.errors.to_json() if floor else unknown,
                "per_joint": {
                    joint: errors.to_json()
                    | {"before": self.per_joint_before[joint].to_json()}
                    | {"noise_floor": at_joint[joint].to_json() if joint in at_joint else unknown}
                    for joint, errors in self.per_joint.items()
                },
            },
            "remaining": self.remaining.to_json(),
            "alarms": list(self.alarms),
            "next_experiment": self.next_experiment.to_json() if self.next_experiment else None,
            "band_hz": self.band,
            "recordings": {"training": self.training, "heldout": self.heldout},
            "problems": [],
        }
        return {key: plain(value) for key, value in facts.items()}


def bad_recording_json(robot: str, problems: Sequence[Problem]) -> Json:
    """The same fields for a recording that no diagnosis was started on; ``problems`` say why."""
    nothing = {"training": None, "heldout": None}
    return {
        "verdict": str(Verdict.BAD_RECORDING),
        "robot": robot,
        "findings": [],
        "located": [],
        "model": {},
        "fit": {"before": nothing, "after": nothing, "noise_floor": nothing, "per_joint": {}},
        "remaining": {
            "heldout": None,
            "structured": None,
            "share": None,
            "slow": None,
            "beyond_noise": None,
            "variable": None,
            "p_value": None,
            "place": None,
        },
        "alarms": [],
        "next_experiment": None,
        "band_hz": None,
        "recordings": nothing,
        "problems": [problem_json(problem) for problem in problems],
    }


def problem_json(problem: Problem) -> Json:
    """Code, message, hint, and the place in the file where it is known."""
    where = problem.where
    place = {"file": where.file, "line": where.line, "column": where.column} if where else None
    return {"code": problem.code, "message": problem.message, "hint": problem.hint, "where": place}


def estimates_json(of: Mapping[str, Estimate]) -> dict[str, Json]:
    return {name: estimate.to_json() for name, estimate in of.items()}
