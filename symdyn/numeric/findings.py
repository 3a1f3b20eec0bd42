"""What a diagnosis says: verdict, findings, fit before and after, what is left. Plain data, JSON-ready."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symdyn.spec.records import Robot

Array = NDArray[np.float64]


class Verdict(StrEnum):
    COMPLETE = "complete"
    MISSING_PHYSICS = "missing_physics"
    AMBIGUOUS = "ambiguous"
    UNEXPLAINED = "unexplained"


@dataclass(frozen=True, slots=True)
class Estimate:
    """A fitted number; ``se`` is its standard error, None where the recording does not tell it alone."""

    value: float
    se: float | None
    unit: str


@dataclass(frozen=True, slots=True)
class Rival:
    """Another effect that explains the same: ``p_value`` of "the finding explains no better"."""

    effect: str
    place: str
    p_value: float


@dataclass(frozen=True, slots=True)
class Alternative:
    """Another effect that would have earned the same step, and the relative held-out error it would have left."""

    effect: str
    place: str
    heldout: float


@dataclass(frozen=True, slots=True)
class Finding:
    """A missing effect. Errors are relative, on held-out data, before and after it was added."""

    effect: str
    title: str
    place: str
    parameters: Mapping[str, Estimate]
    heldout_before: float
    heldout_after: float
    p_value: float  # of "no gain" on the held-out data
    rivals: tuple[Rival, ...]
    alternatives: tuple[Alternative, ...] = ()

    @property
    def heldout_gain(self) -> float:
        """By how much the relative held-out error fell."""
        return self.heldout_before - self.heldout_after


@dataclass(frozen=True, slots=True)
class Errors:
    """Relative error of the effort: size of the residual over that of the measured effort."""

    training: float
    heldout: float


@dataclass(frozen=True, slots=True)
class Remaining:
    """What no known effect explains."""

    heldout: float  # relative error that is left
    structured: bool  # whether it still follows the motion
    share: float  # part of the left residual's power that follows the motion
    variable: str | None  # what it follows most: "position of elbow"
    p_value: float


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


@dataclass(frozen=True, slots=True, eq=False)
class Diagnosis:
    verdict: Verdict
    robot: Robot  # as given
    diagnosed: Robot  # with the effects found and the parameters fitted
    findings: tuple[Finding, ...]
    model: Mapping[str, Estimate]  # the model's own parameters, fitted together with the findings
    before: Errors
    after: Errors
    per_joint: Mapping[str, Errors]  # after
    remaining: Remaining
    alarms: tuple[str, ...]
    band: float  # Hz
    training: str
    heldout: str
    traces: Traces = field(repr=False)

    def to_json(self) -> dict[str, Any]:
        """The facts for other programs; the same words as in the report."""

        def estimates(of: Mapping[str, Estimate]) -> dict[str, dict[str, Any]]:
            return {name: {"value": e.value, "se": e.se, "unit": e.unit} for name, e in of.items()}

        return {
            "verdict": str(self.verdict),
            "robot": self.robot.name,
            "findings": [
                {
                    "effect": f.effect,
                    "place": f.place,
                    "parameters": estimates(f.parameters),
                    "heldout_gain": f.heldout_gain,
                    "heldout_before": f.heldout_before,
                    "heldout_after": f.heldout_after,
                    "p_value": f.p_value,
                    "rivals": [{"effect": r.effect, "place": r.place, "p_value": r.p_value} for r in f.rivals],
                    "alternatives": [
                        {"effect": a.effect, "place": a.place, "heldout": a.heldout} for a in f.alternatives
                    ],
                }
                for f in self.findings
            ],
            "model": estimates(self.model),
            "fit": {
                "before": {"training": self.before.training, "heldout": self.before.heldout},
                "after": {"training": self.after.training, "heldout": self.after.heldout},
                "per_joint": {j: {"training": e.training, "heldout": e.heldout} for j, e in self.per_joint.items()},
            },
            "remaining": {
                "heldout": self.remaining.heldout,
                "structured": self.remaining.structured,
                "share": self.remaining.share,
                "variable": self.remaining.variable,
                "p_value": self.remaining.p_value,
            },
            "alarms": list(self.alarms),
            "band_hz": self.band,
            "recordings": {"training": self.training, "heldout": self.heldout},
        }
