"""Places that move with each other, and those that do not."""

from __future__ import annotations

from dataclasses import replace

from symdyn.compiler import load_robot
from symdyn.numeric.groups import elsewhere
from symdyn.spec.records import Robot

DRIVE = load_robot("irb6-axis1")


def rigid(robot: Robot) -> Robot:
    """Its motor fixed to the joint."""
    (joint,) = robot.joints
    assert joint.drive is not None
    rotors = tuple(replace(r, fixed_to_joint=r.name == "motor") for r in joint.drive.rotors)
    return replace(robot, joints=(replace(joint, drive=replace(joint.drive, rotors=rotors)),))


def test_parts_on_shafts_are_somewhere_else() -> None:
    group = ("axis1.tachometer", "axis1.motor", "axis1.harmonic_drive", "axis1.tachometer")
    assert elsewhere(DRIVE, "axis1.tachometer", group) == ("axis1.motor", "axis1.harmonic_drive")
    assert elsewhere(DRIVE, "axis1", ("axis1",)) == ()


def test_a_rotor_that_is_fixed_to_its_joint_is_not() -> None:
    fixed = rigid(DRIVE)
    assert elsewhere(fixed, "axis1", ("axis1", "axis1.motor")) == ()
    assert elsewhere(fixed, "axis1.motor", ("axis1.motor", "axis1")) == ()
    assert elsewhere(fixed, "axis1.tachometer", ("axis1.tachometer", "axis1.motor", "axis1")) == ("axis1",)


def test_what_the_robot_does_not_have_is_no_place_of_it() -> None:
    assert elsewhere(DRIVE, "axis1", ("axis1", "axis1.a_shaft_that_was_freed")) == ()
