"""Which joints have a torque sensor between their drive and them, and what of the machine can be tested then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.numeric.circuits import current_of
from symdyn.numeric.cut import UNCUT, Part, motor_effort, rotor_of, without_sensors
from symdyn.numeric.filtering.needed import has_hidden_parts
from symdyn.numeric.mechanics import at_joints, mechanics, untested
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Joint, Quantity, Robot, Side


def parts(robot: Robot, recordings: Sequence[Recording]) -> tuple[tuple[Part, ...], list[str]]:
    """What torque sensors cut a robot into, links first, and what is to be said of that; without any, the whole.

    A drive is a part where the effort of its motor was recorded, and the model has a rotor for it to turn.
    """
    sensed = tuple(j.name for j in robot.joints if all(_is_sensed(j, recording) for recording in recordings))
    if not sensed:
        unused = [] if has_hidden_parts(robot, recordings[0]) else robot.joints
        return (UNCUT,), [words for joint in unused if (words := _unused(joint, recordings[0]))]
    cut = [joint for joint in robot.joints if joint.name in sensed]
    told = [_inferred(j) for j in cut if not recordings[0].has(Quantity.EFFORT, j.name, Side.OUTPUT)]
    told += untested(replace(robot, joints=tuple(cut)), mechanics(replace(robot, joints=tuple(cut), effects=())))
    shown = [at_joints(robot, without_sensors(recording, sensed)) for recording in recordings]
    found = [Part(sensed)]
    for joint in cut:
        if rotor_of(joint) is None:
            told.append(f"the drive of {joint.name} is not tested: the model has no rotor there")
        elif any(motor_effort(robot, joint, each) is None for each in shown):
            told.append(f"the drive of {joint.name} is not tested: no effort of its motor was recorded")
        elif not all(each.has(Quantity.POSITION, joint.name) for each in shown):
            told.append(
                f"the drive of {joint.name} is not tested: no position was recorded, of its motor or of the joint"
            )
        else:
            found.append(Part(sensed, joint.name, _driven_at_joint(joint)))
    return tuple(found), told


def _inferred(joint: Joint) -> str:
    return (
        f"the effort of {joint.name} at its link's side is taken for that of a torque sensor at its drive's output, "
        "as that of its motor was recorded, too"
    )


def _driven_at_joint(joint: Joint) -> bool:
    return joint.drive is not None and joint.drive.motor is None and not joint.drive.effort_at


def _is_sensed(joint: Joint, recording: Recording) -> bool:
    if joint.drive is None:
        return False
    if recording.has(Quantity.EFFORT, joint.name, Side.OUTPUT):
        return True
    both = recording.has(Quantity.EFFORT, joint.name, Side.LINK) and _motor_was_recorded(joint, recording)
    return bool(both and joint.drive.rotors)


def _motor_was_recorded(joint: Joint, recording: Recording) -> bool:
    return recording.has(Quantity.EFFORT, joint.name, Side.MOTOR) or any(
        quantity is Quantity.EFFORT and address.startswith(f"{joint.name}.")
        for quantity, address, _ in recording.channels
    )


def _unused(joint: Joint, recording: Recording) -> str:
    if joint.drive is None or current_of(joint, recording) is None or not recording.has(Quantity.EFFORT, joint.name):
        return ""
    return (
        f"the current of {joint.name} is not used beside its effort; if that is of a torque sensor at the drive's "
        'output, its channel has side = "output"'
    )
