"""Whether a machine is measured well enough for inverse dynamics, or has parts that only a filter can see."""

from __future__ import annotations

from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Robot


def has_hidden_parts(robot: Robot, recording: Recording) -> bool:
    """Coordinates that no channel shows, or a circuit between what is imposed and the effort."""
    for joint in robot.joints:
        drive = joint.drive
        if drive is not None and any(not rotor.fixed_to_joint for rotor in drive.rotors):
            return True
        if not recording.has(Quantity.POSITION, joint.name):
            return True
        if drive is not None and drive.motor is not None and not recording.has(Quantity.EFFORT, joint.name):
            return True
    return False
