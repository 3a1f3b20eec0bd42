"""The input that tells two explanations apart where only part of a machine is measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from symdyn.compiler import robot_from_text
from symdyn.faces.experiment_command import add_experiment
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.experiment.limits import read_limits
from symdyn.numeric.experiment.next_experiment import Plan, after_diagnosis
from symdyn.numeric.filtering.input_design import Inputs
from symdyn.numeric.findings import Rival
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import MODEL, record

INPUTS = Inputs(np.array([1.0, -0.5]), np.array([2.0, 0.5]), 500, 2e-3)
ENCODER = MODEL[MODEL.index('[[recording.channel]]\ncolumn = "x"') : MODEL.index('[[recording.channel]]\ncolumn = "w"')]


@given(arrays(np.float64, INPUTS.size, elements=st.floats(0.0, 1.0)))
@settings(max_examples=50, deadline=None)
def test_an_input_goes_no_further_than_the_recorded_ones_and_ends_where_it_begins(point: np.ndarray) -> None:
    u = INPUTS.signal(point)
    assert u.shape == (500, 2)
    assert np.all(np.abs(u - INPUTS.middle) <= INPUTS.reach * (1.0 + 1e-12))
    largest = np.max(np.abs(np.diff(u, axis=0)), axis=0, initial=1e-12)  # the last sample is one before the end
    assert np.all(np.abs(u[[0, -1]] - INPUTS.middle) <= largest)
    np.testing.assert_allclose(INPUTS.signal(point, 0.5) - INPUTS.middle, 0.5 * (u - INPUTS.middle), atol=1e-12)


def test_the_largest_input_is_a_limit_of_a_joint() -> None:
    assert read_limits(["axis:upper=20,input=2"]) == {"axis": {"upper": 20.0, "input": 2.0}}


@pytest.mark.slow  # several diagnoses
def test_a_spring_or_a_weight_is_told_by_the_input_that_is_designed(tmp_path: Path) -> None:
    """Through an angle of 0.2 rad they are the same to current and tachometer; a plant is run under the answer."""
    robot = robot_from_text(MODEL.replace(ENCODER, ""), "drive.toml")
    runs = [record(tmp_path / f"{seed}.csv", robot, seed, size=0.03, unbalance=0.02) for seed in (1, 2)]
    found = diagnose(robot, *runs)
    (told,) = found.findings  # which of the two is told is chance
    effects = (told.effect, *(rival.effect for rival in told.rivals))
    assert (found.verdict, set(effects)) == ("ambiguous", {"linear_spring", "unbalance"})
    limits, path = read_limits(["axis:lower=-20,upper=20,velocity=200,input=2"]), tmp_path / "next.csv"
    asked = add_experiment(found, runs[0], limits, Plan(duration=10.0), path, lambda _: None)
    asked_for = asked.next_experiment
    assert asked_for is not None
    assert asked_for.between == tuple((effect, "axis") for effect in effects)
    assert asked_for.separation > 1000.0
    table = pd.read_csv(path)
    assert list(table.columns) == ["time [s]", "axis.motor.voltage [V]"]
    voltage = table["axis.motor.voltage [V]"].to_numpy()
    assert 0.3 < np.abs(voltage).max() <= 2.0
    again = [record(tmp_path / f"{seed}.csv", robot, seed, voltage, unbalance=0.02) for seed in (5, 6)]
    after = diagnose(robot, *again)
    assert (after.verdict, [f.effect for f in after.findings]) == ("missing_physics", ["unbalance"])
    within = after_diagnosis(found, runs[0], {}, Plan(duration=10.0))  # what was visited tells no more than it told
    assert within is not None
    assert within.told.separation < 10.0
    assert "times the input, travel and speed would" in within.told.why
    assert "input of axis" in within.told.why


@pytest.mark.slow  # a diagnosis, and a compilation
def test_where_a_law_holds_the_other_no_input_is_asked_to_refute_it(robot: Robot, tmp_path: Path) -> None:
    runs = [record(tmp_path / f"{seed}.csv", robot, seed, push=0.02) for seed in (1, 2)]
    found = diagnose(robot, *runs)
    assert after_diagnosis(found, runs[0], {}, Plan(duration=2.0)) is None  # rotor and joint are rigid to each other
    (finding,) = found.findings
    wide = replace(finding, rivals=(Rival("linear_spring", "axis", 0.5),))
    planned = after_diagnosis(replace(found, findings=(wide,)), runs[0], {}, Plan(duration=2.0))
    assert planned is not None
    assert "if constant force offset at axis is true, linear spring at axis fits as well" in planned.told.why
    narrow = {"axis": {"lower": -1e-12, "upper": 1e-12}}
    planned = after_diagnosis(replace(found, findings=(wide,)), runs[0], narrow, Plan(duration=2.0))
    assert planned is not None
    assert planned.told.why.startswith("no input keeps the machine within its limits")
    remembering = replace(finding, rivals=(Rival("dahl_friction", "axis", 0.5),))
    planned = after_diagnosis(replace(found, findings=(remembering,)), runs[0], {}, Plan(duration=2.0))
    assert planned is not None
    assert planned.columns is None
    assert "changes the states of the machine" in planned.told.why
