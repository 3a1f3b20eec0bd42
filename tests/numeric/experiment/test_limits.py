"""Limits of an experiment: what is given, what the robot declares, what a recording visited."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from symdyn.base.errors import InputError, UsageError
from symdyn.numeric.experiment.limits import JointLimits, experiment_limits, read_limits, visited, widened
from symdyn.spec.records import Limits

from ..pendulum import pendulum

FULL = {"lower": -1.0, "upper": 1.0, "velocity": 2.0, "effort": 5.0}


def test_given_limits_are_taken_as_they_are() -> None:
    found = experiment_limits(pendulum(), {"arm": FULL})
    assert found.joints == (JointLimits(-1.0, 1.0, 2.0, np.inf, 5.0),)
    assert found.assumed == ""


def test_robots_own_limits_stand_for_those_not_given() -> None:
    robot = pendulum()
    declared = replace(robot.joints[0], limits=Limits(-0.5, 0.7, 1.5, 4.0))
    found = experiment_limits(replace(robot, joints=(declared,)), {"arm": {"velocity": 0.5}})
    assert found.joints == (JointLimits(-0.5, 0.7, 0.5, np.inf, 4.0),)
    assert found.assumed == ""


def test_what_a_recording_visited_stands_for_the_rest_and_is_told() -> None:
    time = np.linspace(0.0, 10.0, 5001)[:, None]
    seen = visited(0.5 * np.sin(time), 0.5 * np.cos(time), -0.5 * np.sin(time), 3.0 * np.sin(time))
    found = experiment_limits(pendulum(), {"arm": {"velocity": 2.0}}, seen)
    assert found.joints[0].upper == pytest.approx(0.5, rel=1e-3)
    assert found.joints[0].velocity == 2.0
    assert found.joints[0].acceleration == pytest.approx(0.5, rel=0.02)
    assert "the recording already visited" in found.assumed
    assert "lower, upper, acceleration, effort of arm" in found.assumed


def test_joint_without_any_limit_asks_for_one() -> None:
    with pytest.raises(InputError, match=r"range|lower, upper, velocity, acceleration or effort of arm") as caught:
        experiment_limits(pendulum(), {})
    assert [p.code for p in caught.value.problems] == ["SD331"]


@pytest.mark.parametrize(
    "given", [{"elbow": FULL}, {"arm": {**FULL, "upper": -1.0}}, {"arm": {**FULL, "velocity": 0.0}}]
)
def test_limits_that_are_none_are_refused(given: dict[str, dict[str, float]]) -> None:
    with pytest.raises(UsageError, match="SD330"):
        experiment_limits(pendulum(), given)


def test_limits_are_read_from_text() -> None:
    assert read_limits(["arm:lower=-1,upper=1", "arm:velocity=2, effort=5"]) == {"arm": FULL}
    for text in ("arm:lower=x", "arm:high=1", "arm", "arm:velocity=nan"):
        with pytest.raises(UsageError, match="SD330"):
            read_limits([text])


def test_widened_limits() -> None:
    limits = experiment_limits(pendulum(), {"arm": {**FULL, "lower": 0.0}})
    assert widened(limits, "travel", 4.0).joints[0].lower == -1.5
    assert widened(limits, "speed", 4.0).joints[0].velocity == 8.0
    assert widened(limits, "effort", 4.0).joints[0].effort == 20.0
