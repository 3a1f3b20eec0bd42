"""Whether a machine is measured well enough for inverse dynamics, or has parts that only a filter can see."""

from __future__ import annotations

import numpy as np

from symdyn.numeric.circuits import current_of, has_voltage
from symdyn.numeric.gearing import at_joints, coordinate_shown
from symdyn.numeric.recording import Recording
from symdyn.numeric.recording_quality import quantisation_noise
from symdyn.spec.records import Joint, Quantity, Robot, Side

FEW = 2  # joints: a filter of more, with every gear soft, takes more than minutes
BEYOND = 2.0  # times what the encoders leave between the two ends of a gear that is rigid


def has_hidden_parts(robot: Robot, recording: Recording) -> bool:
    """Coordinates that no channel shows, or a circuit between what is imposed and the effort; or a gear to be tested.

    That is one of which both ends were measured, though the model has them move as one: where a robot has one joint,
    or few and the ends go apart. Of arms with more joints inverse dynamics takes the joint's own encoder.
    """
    shown = at_joints(robot, recording)
    for joint in robot.joints:
        drive = joint.drive
        if drive is not None and any(not rotor.fixed_to_joint for rotor in drive.rotors):
            return True
        if not shown.has(Quantity.POSITION, joint.name):
            return True
        if drive is not None and drive.motor is not None and _needs_circuit(robot, joint, shown):
            return True
    gears = [joint.name for joint in robot.joints if measured_at_both_ends(robot, recording, joint.name)]
    if len(robot.joints) == 1:
        return bool(gears)
    return len(robot.joints) <= FEW and any(_goes_apart(robot, recording, joint) for joint in gears)


def _needs_circuit(robot: Robot, joint: Joint, recording: Recording) -> bool:
    """Whether a motor's effort follows from its voltage alone; of a single joint that is held against the current."""
    if recording.has(Quantity.EFFORT, joint.name):
        return False
    tested = len(robot.joints) == 1 and has_voltage(robot, joint, recording)
    return tested or current_of(joint, recording) is None


def measured_at_both_ends(robot: Robot, recording: Recording, joint: str) -> bool:
    """Whether both ends of a rigid transmission have an encoder, and its effort was measured at the motor's."""
    return len(_ends(robot, recording, joint)) > 1 and recording.has(Quantity.EFFORT, joint, Side.MOTOR)


def _ends(robot: Robot, recording: Recording, joint: str) -> list[tuple[np.ndarray, float]]:
    """Positions that show a joint, and the factor from each to it."""
    positions = {key: values for key, values in recording.channels.items() if key[0] is Quantity.POSITION}
    told = [(values, coordinate_shown(robot, key)) for key, values in positions.items()]
    return [(values, factor) for values, (at, factor) in told if at == joint]


def _goes_apart(robot: Robot, recording: Recording, joint: str) -> bool:
    """Whether what is between two encoders is more than their steps, and than noise that third differences hold."""
    (one, gain), (other, factor) = _ends(robot, recording, joint)[:2]
    apart = [(gain * one - factor * other)[part] for part in recording.segments]
    size = np.sqrt(np.mean(np.concatenate([part - part.mean() for part in apart]) ** 2))
    white = np.sqrt(np.mean(np.concatenate([np.diff(part, n=3) for part in apart]) ** 2) / 20.0)
    steps = np.hypot(gain * quantisation_noise(one), factor * quantisation_noise(other))
    return bool(size > BEYOND * max(white, steps))
