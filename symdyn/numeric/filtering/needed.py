"""Whether a machine is measured well enough for inverse dynamics, or has parts that only a filter can see."""

from __future__ import annotations

from symdyn.numeric.filtering.gears import coordinate_shown
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Robot, Side


def has_hidden_parts(robot: Robot, recording: Recording) -> bool:
    """Coordinates that no channel shows, or a circuit between what is imposed and the effort; or a gear to be tested.

    That is one of which both ends were measured, though the model has them move as one. Of arms with more joints
    inverse dynamics takes the joint's own encoder: a filter of all of them would take hours.
    """
    for joint in robot.joints:
        drive = joint.drive
        if drive is not None and any(not rotor.fixed_to_joint for rotor in drive.rotors):
            return True
        if not recording.has(Quantity.POSITION, joint.name):
            return True
        if drive is not None and drive.motor is not None and not recording.has(Quantity.EFFORT, joint.name):
            return True
    return len(robot.joints) == 1 and measured_at_both_ends(robot, recording, robot.joints[0].name)


def measured_at_both_ends(robot: Robot, recording: Recording, joint: str) -> bool:
    """Whether both ends of a rigid transmission have an encoder, and its effort was measured at the motor's."""
    positions = [key for key in recording.channels if key[0] is Quantity.POSITION]
    there = [key for key in positions if coordinate_shown(robot, key)[0] == joint]
    return len(there) > 1 and recording.has(Quantity.EFFORT, joint, Side.MOTOR)
