"""What changed since the model was fitted: a payload, or a sensor of torque that shows too much."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.base.errors import UsageError
from symdyn.compiler import compile_robot, robot_from_text
from symdyn.numeric.candidates import fitted_parameters, held_parameters
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Estimate
from symdyn.numeric.freed import PointPayload, missing_numbers
from symdyn.numeric.identify import identify
from symdyn.numeric.observation import observe
from symdyn.numeric.reading import Reading, declared
from symdyn.numeric.readings import read
from symdyn.numeric.setting import prepare
from symdyn.numeric.workbench import Workbench
from symdyn.spec.edit import add_effect, set_parameter

from .arm_of_two import ARM_OF_TWO, run
from .pendulum import GRAVITY

TRUE = {"m1": "1 kg", "m2": "0.8 kg", "r1": "0.2 m", "r2": "0.15 m", "I1": "0.02 kg m^2", "I2": "0.01 kg m^2"}


def known() -> str:
    """The model with the numbers that the torques were made with."""
    text = ARM_OF_TWO
    robot = robot_from_text(text, "two.toml")
    for name, value in {**TRUE, "b1": "0.3 N m s/rad", "b2": "0.12 N m s/rad"}.items():
        text = set_parameter(text, robot, name, value)
    return text


@pytest.mark.slow  # whole diagnoses
@pytest.mark.parametrize("place", ["two", "one"])
def test_a_payload_is_weighed_where_the_model_is_held(place: str) -> None:
    """Whichever link carries it."""
    robot, true = robot_from_text(known(), "two.toml"), (0.25, 0.12, 0.05)
    training, heldout = (run(i, carried=true) if place == "two" else run(i, mounted=true) for i in (1, 2))
    found = diagnose(robot, training, heldout, hold=["*"])
    assert [(f.effect, f.place) for f in found.findings] == [("payload", place)]
    told = found.findings[0].parameters
    for name, value in zip(("mass", "com_x", "com_y"), true, strict=True):
        se = told[name].se
        assert se is not None
        assert abs(told[name].value - value) < 4.0 * se < 0.1 * value
    assert not found.remaining.structured
    assert [e.type for e in found.diagnosed.effects].count("payload") == 1


def test_a_mass_that_takes_up_a_payload_is_suspect() -> None:
    """Where the centre of the last link is free, too, its own numbers explain what it carries."""
    robot, carried = robot_from_text(ARM_OF_TWO, "two.toml"), (3.0, 0.15, 0.0)
    found = diagnose(robot, run(1, carried=carried), run(2, carried=carried))
    assert (found.verdict, found.findings) == ("complete", ())
    suspect = [alarm for alarm in found.alarms if "absorbing" in alarm and alarm.startswith("m2 went from 0.7 to 3.")]
    assert len(suspect) == 1, found.alarms


def test_a_moment_without_a_mass_is_no_payload() -> None:
    """A fit goes there where something else weighs on one joint: to nothing, at any distance."""
    told = {"mass": Estimate(1e-7, 4e-7, "kg"), "com_x": Estimate(5e4, None, "m")}
    assert not PointPayload("two").credible(told)
    assert PointPayload("two").credible(told | {"mass": Estimate(0.2, 0.01, "kg")})


@pytest.mark.slow
def test_gravity_is_doubted_unless_it_is_held() -> None:
    """``*`` stands for the parameters of a fit alone: a base may have been mounted anew since."""
    robot = robot_from_text(known(), "two.toml")
    for hold, doubted in ((["*"], True), (["gravity"], False), (["*", "gravity"], False)):
        setting = prepare(robot, run(1), run(2), lambda _: None, held_parameters(robot, fitted_parameters(robot), hold))
        asked = {freed.key for freed in missing_numbers(setting)}
        assert (("gravity", "base") in asked) is doubted
        assert (("payload", "one") in asked) is ("*" in hold)


@pytest.mark.slow
def test_a_weight_that_is_not_felt_is_told() -> None:
    """A model that weighs twenty times as much as the arm."""
    heavy = known().replace(f"-{GRAVITY}", "-200.0")
    found = diagnose(robot_from_text(heavy, "two.toml"), run(1), run(2), hold=["*"])
    assert [f.effect for f in found.findings] == ["gravity"]
    assert any(alarm.startswith("5 % of gravity is left") for alarm in found.alarms), found.alarms


@pytest.mark.slow  # a whole diagnosis
def test_nothing_is_found_where_nothing_changed() -> None:
    found = diagnose(robot_from_text(known(), "two.toml"), run(1), run(2), hold=["*"])
    assert (found.verdict, found.findings, found.model) == ("complete", (), {})


@pytest.mark.slow  # two whole diagnoses
@pytest.mark.parametrize("joint", [0, 1])
def test_a_sensor_of_torque_that_shows_too_much_is_named(joint: int) -> None:
    """All masses and frictions are free: the torque of the other joint contradicts it."""
    shown = (1.07, 1.0) if joint == 0 else (1.0, 1.07)
    found = diagnose(robot_from_text(ARM_OF_TWO, "two.toml"), run(1, shown=shown), run(2, shown=shown))
    assert [(f.effect, f.place) for f in found.findings] == [("effort_gain", ("one", "two")[joint])]
    told = found.findings[0].parameters["gain"]
    assert told.se is not None
    assert abs(told.value - 1.0 / 1.07) < 4.0 * told.se < 0.02
    assert not found.remaining.structured


def test_efforts_are_compared_as_they_were_shown() -> None:
    """In units of the efforts that act, a gain of nothing would leave no error at all."""
    robot = robot_from_text(add_effect(ARM_OF_TWO, "effort_gain", "two", {"gain": "0.5"}), "two.toml")
    assert declared(robot) == (Reading(), Reading(effort_gain=0.5))
    kernel, recording = compile_robot(robot).kernel(), run(1)
    seen = observe(robot, kernel, recording)
    plain, halved = (Workbench(kernel, o) for o in (seen, read(seen, declared(robot))))
    np.testing.assert_allclose(halved.effort, plain.effort, rtol=1e-12)
    p = 0.0 * kernel.values
    np.testing.assert_allclose(halved.residual(p), plain.residual(p), rtol=1e-12)
    names = kernel.parameters[:3]
    np.testing.assert_allclose(
        halved.columns(kernel.values, names), plain.columns(kernel.values, names) * [[[1.0], [2.0]]], rtol=1e-12
    )


def test_a_fit_reads_a_recording_as_the_model_says() -> None:
    """A sensor that shows twice the torque, and is known to."""
    doubled = run(1, shown=(2.0, 2.0))
    text = ARM_OF_TWO
    for joint in ("one", "two"):
        text = add_effect(text, "effort_gain", joint, {"gain": "0.5"})
    fitted = identify(robot_from_text(text, "two.toml"), doubled)
    assert fitted.parameters["b1"].value == pytest.approx(0.3, rel=0.02)


def test_parameters_that_no_fit_moves_cannot_be_held() -> None:
    robot, runs = robot_from_text(ARM_OF_TWO, "two.toml"), (run(1), run(2))
    with pytest.raises(UsageError, match="moves a parameter `m3`") as error:
        diagnose(robot, *runs, hold=["m3"])
    assert "m1" in (error.value.problems[0].hint or "")
    held = diagnose(robot_from_text(known(), "two.toml"), *runs, hold=["m*"])
    assert not {"m1", "m2"} & set(held.model)
    assert "r1" in held.model
