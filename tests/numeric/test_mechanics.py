"""Arms whose drives have more coordinates than a filter can follow go by inverse dynamics, and are told so."""

from __future__ import annotations

import math
from dataclasses import replace
from types import MappingProxyType

import pytest

from symdyn.base.errors import InputError
from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.filtering.needed import has_hidden_parts
from symdyn.numeric.identify import identify
from symdyn.numeric.mechanics import mechanics, untested
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Robot, Side

from .arm_of_two import rubbing, with_drives

RATIO = 100.0


def soft() -> Robot:
    """Two rotors and two shafts on each joint; play in one of them is in the model."""
    drive = f"""ratio = {RATIO:g}
rotors = [{{ name = "motor", inertia = "1e-9 kg m^2" }}, {{ name = "wheel", inertia = "1e-9 kg m^2" }}]
shafts = [
  {{ name = "belt", from = "motor", to = "wheel", stiffness = "9 N m/rad", damping = "1e-3 N m s/rad" }},
  {{ name = "gear", from = "wheel", to = "joint", stiffness = "9 N m/rad", damping = "1e-3 N m s/rad" }},
]
effort_at = "motor"
"""
    play = '[[effect]]\ntype = "backlash"\nat = "one.gear"\nclearance = "1e-4 rad"\n'
    return robot_from_text(with_drives({"one": drive, "two": drive}) + "\n" + play, "soft.toml")


def at_motors(seed: int, level: float) -> Recording:
    """By encoders and torques of the motors, with Coulomb friction at the second joint."""
    recording = rubbing(seed, level)
    channels = {}
    for (quantity, joint, _), values in recording.channels.items():
        if quantity is Quantity.POSITION:
            channels[quantity, f"{joint}.motor", Side.LINK] = RATIO * values
        else:
            channels[quantity, joint, Side.MOTOR] = values / RATIO
    return replace(recording, channels=MappingProxyType(channels))


@pytest.mark.slow
def test_an_arm_of_many_coordinates_is_diagnosed_with_rigid_transmissions() -> None:
    robot, runs = soft(), [at_motors(seed, 0.2) for seed in (1, 2)]
    assert not has_hidden_parts(robot, runs[0])
    found = diagnose(robot, *runs, band=12.0)
    assert [(f.effect, f.place) for f in found.findings] == [("coulomb_friction", "two")]
    assert found.findings[0].parameters["level"].value == pytest.approx(0.2, rel=0.02)
    for whole, of_joints in ((found.before, found.per_joint_before), (found.after, found.per_joint)):
        assert math.hypot(*(e.heldout for e in of_joints.values())) / math.sqrt(2) == pytest.approx(whole.heldout)
    assert found.per_joint_before["two"].heldout > 2 * found.per_joint_before["one"].heldout
    assert {
        f"the transmission of {j} is taken for rigid, and its shafts are not tested" for j in ("one", "two")
    } <= set(found.alarms)
    assert found.diagnosed.joints[0].drive == robot.joints[0].drive  # what was not tested stays in the model
    assert [effect.type for effect in found.diagnosed.effects].count("backlash") == 1


def test_a_fit_by_inverse_dynamics_alone_wants_rigid_transmissions() -> None:
    with pytest.raises(InputError) as caught:
        identify(soft(), at_motors(1, 0.0))
    assert [problem.code for problem in caught.value.problems] == ["SD521"]
    assert "one.motor, one.wheel, two.motor, two.wheel" in str(caught.value)


def test_mechanics_have_nothing_of_shafts_and_the_same_again() -> None:
    robot = soft()
    rigid = mechanics(robot)
    assert not any(joint.drive.shafts for joint in rigid.joints if joint.drive)
    assert [effect.type for effect in rigid.effects] == ["viscous_friction"] * 2
    assert mechanics(rigid) is rigid
    assert untested(robot, robot) == ()
