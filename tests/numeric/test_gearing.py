"""What the motor of a rigid gear shows is the joint's, by the ratio: an arm recorded at its motors is the same arm."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.filtering.needed import has_hidden_parts
from symdyn.numeric.identify import identify
from symdyn.numeric.mechanics import at_joints
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Robot, Side

from .arm_of_two import ARM_OF_TWO, rubbing, run, with_drives

RATIOS = {"one": 100.0, "two": -80.0}
POSITION, EFFORT = Quantity.POSITION, Quantity.EFFORT


def geared(rotors: bool = True) -> Robot:
    rotor = 'rotors = [{ name = "motor", inertia = "1e-9 kg m^2", fixed_to_joint = true }]\n' if rotors else ""
    drives = {name: f"ratio = {ratio:g}\n{rotor}" for name, ratio in RATIOS.items()}
    return robot_from_text(with_drives(drives), "geared.toml")


def at_motors(recording: Recording, part: str = "") -> Recording:
    """The same run told by encoders and torques of the motors: of their side, or of the ``part`` of the drives."""
    channels = {}
    for (quantity, joint, _), values in recording.channels.items():
        factor = RATIOS[joint] if quantity is POSITION else 1.0 / RATIOS[joint]
        channels[quantity, f"{joint}.{part}" if part else joint, Side.LINK if part else Side.MOTOR] = factor * values
    return replace(recording, channels=MappingProxyType(channels))


@pytest.mark.parametrize(("rotors", "part"), [(True, ""), (True, "motor"), (False, "")])
def test_an_arm_recorded_at_its_motors_is_fitted_as_at_its_joints(rotors: bool, part: str) -> None:
    robot, recording = geared(rotors), run(1)
    shown = at_motors(recording, part)
    assert not has_hidden_parts(robot, shown)
    told, expected = identify(robot, shown, band=12.0), identify(robot, recording, band=12.0)
    assert told.error == pytest.approx(expected.error, rel=1e-6)
    assert expected.error < 0.02
    for name, estimate in expected.parameters.items():
        assert told.parameters[name].value == pytest.approx(estimate.value, rel=1e-6, abs=1e-9)


def test_the_encoder_of_the_joint_goes_before_that_of_its_motor() -> None:
    recording = run(1)
    coarse = {key: np.round(values, 1) for key, values in at_motors(recording).channels.items()}
    both = replace(recording, channels=MappingProxyType({**coarse, **recording.channels}))
    shown = at_joints(geared(), both)
    for key, values in recording.channels.items():
        np.testing.assert_array_equal(shown.channels[key], values)


def test_what_is_not_behind_a_gear_stays_as_it_is() -> None:
    recording = run(1)
    assert at_joints(geared(), recording) is recording
    swapped = {(quantity, joint, Side.MOTOR): v for (quantity, joint, _), v in recording.channels.items()}
    shown = at_joints(robot_from_text(ARM_OF_TWO, "arm.toml"), replace(recording, channels=MappingProxyType(swapped)))
    for key, values in recording.channels.items():
        np.testing.assert_array_equal(shown.channels[key], values)


@pytest.mark.slow
def test_friction_is_found_by_an_arms_motors_alone() -> None:
    robot, runs = geared(), [at_motors(rubbing(seed, 0.2)) for seed in (1, 2)]
    found = diagnose(robot, *runs, band=12.0)
    assert [(f.effect, f.place, f.group) for f in found.findings] == [("coulomb_friction", "two", ("two", "two.motor"))]
    assert found.findings[0].parameters["level"].value == pytest.approx(0.2, rel=0.02)


@pytest.mark.parametrize(("twist", "hidden"), [(0.0, False), (2e-3, True)])
def test_gears_of_few_joints_are_doubted_where_their_ends_go_apart(twist: float, hidden: bool) -> None:
    recording = run(1)
    bent = dict(at_motors(recording).channels)
    bent[POSITION, "two", Side.MOTOR] = RATIOS["two"] * (
        recording.channels[POSITION, "two", Side.LINK]
        + twist * recording.channels[EFFORT, "two", Side.LINK]
        + 5e-6 * np.random.default_rng(5).standard_normal(len(recording.time))
    )
    both = replace(recording, channels=MappingProxyType({**bent, **recording.channels}))
    assert has_hidden_parts(geared(), both) is hidden
