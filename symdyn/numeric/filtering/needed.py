"""Whether a machine is measured well enough for inverse dynamics, or has parts that only a filter can see."""

from __future__ import annotations

import numpy as np

from symdyn.numeric.circuits import current_of, has_voltage
from symdyn.numeric.gearing import coordinate_shown
from symdyn.numeric.mechanics import at_joints, soft_rotors
from symdyn.numeric.recording import Recording
from symdyn.numeric.recording_quality import quantisation_noise
from symdyn.spec.records import Joint, Quantity, Robot, Side

MOST = 4  # coordinates of a robot with several joints: a filter takes minutes then, and hours beyond
BEYOND = 2.0  # times what the encoders leave between the two ends of a gear that is rigid


def has_hidden_parts(robot: Robot, recording: Recording) -> bool:
    """Whether a filter is asked: for joints that no channel shows or drives, soft transmissions, gears in doubt.

    Those are gears of which both ends were measured, though the model has them move as one, of a robot of one joint, or
    of few that go apart. An arm with more coordinates goes by inverse dynamics, its transmissions taken for rigid.
    """
    shown, joints = at_joints(robot, recording), robot.joints
    if not all(
        shown.has(Quantity.POSITION, joint.name) and not _needs_circuit(robot, joint, shown) for joint in joints
    ):
        return True
    if soft_rotors(robot):
        return can_follow(robot)
    gears = [joint.name for joint in joints if measured_at_both_ends(robot, recording, joint.name)]
    if len(joints) == 1:
        return bool(gears)
    return len(joints) + len(gears) <= MOST and any(_goes_apart(robot, recording, joint) for joint in gears)


def can_follow(robot: Robot) -> bool:
    """Whether a filter has an answer in minutes: a robot of one joint, or of few coordinates."""
    return len(robot.joints) == 1 or len(robot.joints) + len(soft_rotors(robot)) <= MOST


def _needs_circuit(robot: Robot, joint: Joint, recording: Recording) -> bool:
    """Whether a motor's effort follows from its voltage alone; of a single joint that is held against the current."""
    if joint.drive is None or joint.drive.motor is None or recording.has(Quantity.EFFORT, joint.name):
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
