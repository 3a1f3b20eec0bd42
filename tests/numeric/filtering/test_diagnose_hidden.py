"""Concealed effects in a drive of which the load is not measured."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symdyn.base.errors import UsageError
from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Diagnosis, Verdict
from symdyn.spec.edit import set_parameter
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import J_L, J_M, TRUE, record


def diagnosed(robot: Robot, folder: Path, **concealed: float) -> Diagnosis:
    runs = [record(folder / f"{seed}.csv", robot, seed, **concealed) for seed in (1, 2)]
    return diagnose(robot, *runs)


def test_nothing_missing_is_complete(robot: Robot, tmp_path: Path) -> None:
    found = diagnosed(robot, tmp_path)
    assert found.verdict is Verdict.COMPLETE
    assert not found.findings
    assert not found.located
    assert not found.traces.missing
    assert found.noise_floor is not None
    assert found.after.heldout < 1.1 * found.noise_floor.errors.heldout
    assert found.model["R"].value == pytest.approx(1.6, rel=0.01)  # the model said 1.8


def test_coulomb_friction_is_named_placed_and_written_down(robot: Robot, tmp_path: Path) -> None:
    found = diagnosed(robot, tmp_path, coulomb=0.03)
    assert [f.effect for f in found.findings] == ["coulomb_friction"]
    (finding,) = found.findings
    assert set(finding.group) == {"axis", "axis.motor"}  # rigid to each other
    level, se = finding.parameters["level"].value, finding.parameters["level"].se
    # the torque constant is 6 % off the back-EMF constant: friction in units of the inertia is told sharply
    inertia = found.model["J_m"].value + found.model["J_l"].value
    assert level / inertia == pytest.approx(0.03 / (J_M + J_L), rel=0.03)
    assert se is not None
    assert abs(level - 0.03) < 3.0 * se < 0.006
    assert {place: values["level"].value for place, values in finding.elsewhere.items()} == {
        place: level for place in finding.group if place != finding.place
    }
    assert finding.evidence > 100.0
    assert found.located[0].place == "axis"
    assert found.located[0].when[0] in ("sign of speed", "reversal")
    assert found.after.heldout < 0.5 * found.before.heldout
    assert 'type = "coulomb_friction"' in found.diagnosed.text
    (force,) = found.traces.missing
    assert force.place == finding.place
    # it resists; at speed the model's own viscous friction had taken up some of it
    assert np.corrcoef(force.before, np.sign(force.v))[0, 1] > 0.6
    assert np.std(force.after) < 0.2 * np.std(force.before)


@pytest.mark.slow
def test_forces_that_no_law_tells_are_unexplained_and_have_their_place(robot: Robot, tmp_path: Path) -> None:
    """They are nearly white: noise of the equations, which is white, must not take them up."""
    found = diagnosed(robot, tmp_path, gusts=0.03)
    assert found.verdict is Verdict.UNEXPLAINED
    assert not found.findings
    assert found.located[0].place == "axis"
    assert found.remaining.structured


@pytest.mark.slow
def test_a_constant_is_found_beside_friction_though_an_unknown_force_could_take_it_up(
    robot: Robot, tmp_path: Path
) -> None:
    found = diagnosed(robot, tmp_path, coulomb=0.03, push=0.012)
    told = {f.effect: f for f in found.findings}
    assert set(told) == {"coulomb_friction", "force_offset"}
    ratio = told["force_offset"].parameters["offset"].value / told["coulomb_friction"].parameters["level"].value
    assert ratio == pytest.approx(-0.4, rel=0.05)  # an offset counts as resistance
    assert not found.remaining.structured


@pytest.mark.slow  # compiles the machine with a shaft in it
def test_a_transmission_taken_for_rigid_gets_its_shaft(robot: Robot, tmp_path: Path) -> None:
    found = diagnosed(robot, tmp_path, stiffness=1.0)
    assert [f.effect for f in found.findings] == ["joint_compliance"]
    stiffness = found.findings[0].parameters["stiffness"]
    assert stiffness.se is not None
    assert abs(stiffness.value - 1.0) < 3.0 * stiffness.se
    drive = found.diagnosed.joints[0].drive
    assert drive is not None
    assert not drive.rotors[0].fixed_to_joint
    assert [s.name for s in drive.shafts] == ["transmission"]


@pytest.mark.slow
def test_an_ammeter_that_is_off_is_no_offset_of_the_amplifier(robot: Robot, tmp_path: Path) -> None:
    found = diagnosed(robot, tmp_path, offset=0.1)
    assert [(f.effect, f.place) for f in found.findings] == [("ammeter", "axis.circuit")]
    offset = found.findings[0].parameters["offset"]
    assert offset.se is not None
    assert abs(offset.value - 0.1) < 3.0 * offset.se
    assert 'type = "ammeter"' in found.diagnosed.text


@pytest.mark.slow
def test_a_dead_zone_that_differs_by_direction_is_that_of_an_input_with_an_offset(robot: Robot, tmp_path: Path) -> None:
    runs = [record(tmp_path / f"{seed}.csv", robot, seed, bias=0.6, dead=0.9) for seed in (1, 2)]
    found = diagnose(robot, *runs)
    told = {f.effect: f.parameters for f in found.findings}
    assert set(told) == {"amplifier_offset", "amplifier_dead_zone"}
    assert told["amplifier_offset"]["offset"].value == pytest.approx(0.6, rel=0.02)
    assert told["amplifier_dead_zone"]["half_width"].value == pytest.approx(0.9, rel=0.02)
    text = found.diagnosed.text
    assert text.index("amplifier_offset") < text.index("amplifier_dead_zone")  # the order in which the input passes
    again = diagnose(found.diagnosed, *runs, hold=("*",))  # the new model does what the fit did
    assert again.verdict is Verdict.COMPLETE
    assert again.before.heldout == pytest.approx(found.after.heldout, rel=0.05)


@pytest.mark.slow  # a machine that reacts late looks like one with a large inductance first: long fits
def test_a_late_input_is_told_to_a_part_of_a_sample(robot: Robot, tmp_path: Path) -> None:
    found = diagnosed(robot, tmp_path, late=5.3e-3)
    assert [(f.effect, f.place) for f in found.findings] == [("input_delay", "axis.circuit")]
    delay = found.findings[0].parameters["delay"]
    assert delay.value == pytest.approx(5.3e-3, abs=0.05e-3)  # a sample is 2 ms
    assert found.model["L"].value == pytest.approx(0.4e-3, rel=0.3)  # and not what the delay looked like


@pytest.mark.slow  # compiles a machine for each law that remembers
def test_friction_over_a_distance_is_told_from_friction_that_jumps(robot: Robot, tmp_path: Path) -> None:
    found = diagnosed(robot, tmp_path, dahl=0.03, distance=0.05)
    assert [f.effect for f in found.findings] == ["dahl_friction"]
    (finding,) = found.findings
    assert set(finding.group) == {"axis", "axis.motor"}
    level, stiffness = (finding.parameters[name].value for name in ("level", "stiffness"))
    assert level / stiffness == pytest.approx(0.05, rel=0.03)
    inertia = found.model["J_m"].value + found.model["J_l"].value
    assert level / inertia == pytest.approx(0.03 / (J_M + J_L), rel=0.03)
    assert found.after.heldout < 0.5 * found.before.heldout
    assert 'type = "dahl_friction"' in found.diagnosed.text


@pytest.mark.slow  # compiles the machine with a state of the tachometer
def test_a_tachometer_that_lags_gets_its_time_constant(robot: Robot, tmp_path: Path) -> None:
    found = diagnosed(robot, tmp_path, lag=8e-3)
    assert [(f.effect, f.place) for f in found.findings] == [("tachometer", "axis.motor")]
    lag = found.findings[0].parameters["time_constant"]
    assert lag.value == pytest.approx(8e-3, rel=0.03)
    tachometers = [e for e in found.diagnosed.effects if e.type == "tachometer"]
    assert len(tachometers) == 1
    assert "time_constant" in dict(tachometers[0].values)


@pytest.mark.slow  # one more whole diagnosis
def test_a_weight_beside_the_axis_is_no_ripple(robot: Robot, tmp_path: Path) -> None:
    found = diagnosed(robot, tmp_path, unbalance=0.02)
    assert [f.effect for f in found.findings] == ["unbalance"]
    values = {name: estimate.value for name, estimate in found.findings[0].parameters.items()}
    assert values["eccentricity"] == 0.01  # assumed: only its product with the mass shows
    inertia = found.model["J_m"].value + found.model["J_l"].value + values["mass"] * values["eccentricity"] ** 2
    assert 9.81 * values["mass"] * values["eccentricity"] / inertia == pytest.approx(0.02 / (J_M + J_L), rel=0.03)
    assert abs(values["phase"]) < 0.02


@pytest.mark.slow  # one more whole diagnosis
@pytest.mark.parametrize(
    ("concealed", "named"),
    [({"coulomb": 0.03}, ["coulomb_friction"]), ({}, [])],
)
def test_what_has_changed_since_the_model_was_fitted(
    robot: Robot, tmp_path: Path, concealed: dict[str, float], named: list[str]
) -> None:
    """All its numbers are right, and held: a torque is told as sharply as the torque constant is known."""
    text = robot.text
    for name, value in TRUE.items():
        text = set_parameter(text, robot, name, value)
    runs = [record(tmp_path / f"{seed}.csv", robot, seed, **concealed) for seed in (1, 2)]
    found = diagnose(robot_from_text(text, "drive.toml"), *runs, hold=["*"])
    assert [f.effect for f in found.findings] == named
    assert found.model == {}
    assert not found.remaining.structured
    if named:
        level = found.findings[0].parameters["level"]
        assert level.se is not None
        assert abs(level.value - 0.03) < 3.0 * level.se < 0.1 * 0.03  # eight times that beside free ones


@pytest.mark.slow  # compiles the machine with a shaft in it
def test_a_shaft_is_found_beside_numbers_that_are_held(robot: Robot, tmp_path: Path) -> None:
    runs = [record(tmp_path / f"{seed}.csv", robot, seed, stiffness=1.0) for seed in (1, 2)]
    found = diagnose(
        robot_from_text(robot.text.replace("0.08 N m/A", "0.085 N m/A"), "drive.toml"), *runs, hold=["K_*"]
    )
    assert [f.effect for f in found.findings] == ["joint_compliance"]
    assert not {"K_T", "K_E"} & set(found.model)
    assert "R" in found.model


def test_a_parameter_that_no_filter_fits_cannot_be_held(robot: Robot, tmp_path: Path) -> None:
    run = record(tmp_path / "1.csv", robot, 1)
    with pytest.raises(UsageError, match="moves a parameter `K_X`") as error:
        diagnose(robot, run, run, hold=["K_X"])
    assert "K_T" in (error.value.problems[0].hint or "")
