"""What changed since the model was fitted: a payload, or a sensor of torque that shows too much."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.base.errors import UsageError
from symdyn.compiler import compile_robot, robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.identify import identify
from symdyn.numeric.observation import observe
from symdyn.numeric.reading import Reading, declared
from symdyn.numeric.readings import read
from symdyn.numeric.workbench import Workbench
from symdyn.spec.edit import add_effect, set_parameter

from .arm_of_two import ARM_OF_TWO, run

TRUE = {"m1": "1 kg", "m2": "0.8 kg", "r1": "0.2 m", "r2": "0.15 m", "I1": "0.02 kg m^2", "I2": "0.01 kg m^2"}


def known() -> str:
    """The model with the numbers that the torques were made with."""
    text = ARM_OF_TWO
    robot = robot_from_text(text, "two.toml")
    for name, value in {**TRUE, "b1": "0.3 N m s/rad", "b2": "0.12 N m s/rad"}.items():
        text = set_parameter(text, robot, name, value)
    return text


def test_a_payload_is_weighed_where_the_model_is_held() -> None:
    robot = robot_from_text(known(), "two.toml")
    carried = (0.25, 0.12, 0.05)
    found = diagnose(robot, run(1, carried=carried), run(2, carried=carried), hold=["*"])
    assert [(f.effect, f.place) for f in found.findings] == [("payload", "two")]
    told = found.findings[0].parameters
    for name, true in zip(("mass", "com_x", "com_y"), carried, strict=True):
        se = told[name].se
        assert se is not None
        assert abs(told[name].value - true) < 4.0 * se < 0.1 * true
    assert not found.remaining.structured
    assert [e.type for e in found.diagnosed.effects].count("payload") == 1


def test_a_mass_that_takes_up_a_payload_is_suspect() -> None:
    """Where the centre of the last link is free, too, its own numbers explain what it carries."""
    robot, carried = robot_from_text(ARM_OF_TWO, "two.toml"), (3.0, 0.15, 0.0)
    found = diagnose(robot, run(1, carried=carried), run(2, carried=carried))
    assert (found.verdict, found.findings) == ("complete", ())
    suspect = [alarm for alarm in found.alarms if "absorbing" in alarm and alarm.startswith("m2 went from 0.7 to 3.")]
    assert len(suspect) == 1, found.alarms


def test_nothing_is_found_where_nothing_changed() -> None:
    found = diagnose(robot_from_text(known(), "two.toml"), run(1), run(2), hold=["*"])
    assert (found.verdict, found.findings, found.model) == ("complete", (), {})


@pytest.mark.parametrize("joint", [pytest.param(0, marks=pytest.mark.slow), 1])
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
