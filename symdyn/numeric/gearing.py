"""What a drive's motor shows of a joint that is geared to it rigidly: positions, speeds and efforts, by the ratio."""

from __future__ import annotations

from symdyn.numeric.recording import ChannelKey
from symdyn.spec.monomials import value_of
from symdyn.spec.records import JOINT_END, Joint, Monomial, Robot, Side

TACHOMETER = "tachometer"


def number(robot: Robot, monomial: Monomial) -> float:
    """At the parameters as given; a free one counts as 1."""
    return value_of(monomial, {p.name: 1.0 if p.value is None else p.value for p in robot.parameters}) or 0.0


def gear_ratio(robot: Robot, joint: Joint) -> float:
    """Turns of the motor per turn of the joint (per metre, if it slides)."""
    return number(robot, joint.drive.ratio) if joint.drive is not None else 1.0


def reach(robot: Robot, address: str) -> float:
    """How far a part of a drive goes while its joint goes 1 (rad or m), if nothing twists."""
    return gear_ratio(robot, joint_of(robot, address)) if "." in address else 1.0


def joint_name(address: str) -> str:
    """Of the joint that an address is, or belongs to."""
    return address.partition(".")[0]


def joint_of(robot: Robot, address: str) -> Joint:
    """The joint that an address is, or belongs to."""
    return next(joint for joint in robot.joints if joint.name == joint_name(address))


def coordinate_shown(robot: Robot, key: ChannelKey) -> tuple[str, float]:
    """The coordinate that a channel of position or speed shows, and the factor from the channel to it."""
    joint = joint_of(robot, key[1])
    at, geared = _coordinate(joint, key)
    return at, 1.0 / gear_ratio(robot, joint) if geared else 1.0


def effort_shown(robot: Robot, key: ChannelKey) -> tuple[str, float]:
    """The coordinate that a channel of effort acts on, and the factor from the channel to that effort."""
    joint = joint_of(robot, key[1])
    at, geared = _coordinate(joint, key)
    return at, gear_ratio(robot, joint) if geared else 1.0


def _coordinate(joint: Joint, key: ChannelKey) -> tuple[str, bool]:
    """Where a channel is, and whether a rigid gear is between."""
    _, address, side = key
    if "." not in address and side is Side.MOTOR and joint.drive is not None:
        rotor = motor_rotor(joint)
        if rotor is None:
            return joint.name, True
        address = rotor
    return (joint.name, True) if turns_with_joint(joint, address) else (address, False)


def turns_with_joint(joint: Joint, address: str) -> bool:
    """Whether it is the address of a rotor that has no coordinate of its own."""
    rotors = joint.drive.rotors if joint.drive is not None else ()
    return any(r.fixed_to_joint and address == f"{joint.name}.{r.name}" for r in rotors)


def shaft_end(joint: Joint, end: str) -> str:
    """The coordinate that an end of a shaft turns with, its name in the drive given: the joint's, or a rotor's own."""
    at = f"{joint.name}.{end}"
    return joint.name if end == JOINT_END or turns_with_joint(joint, at) else at


def motor_rotor(joint: Joint) -> str | None:
    """The rotor that a motor-side encoder shows: that of the motor, or which the effort acts on, or the first."""
    if joint.drive is None:
        return None
    if joint.drive.motor is not None:
        return f"{joint.name}.{joint.drive.motor.at}"
    if joint.drive.effort_at:
        return f"{joint.name}.{joint.drive.effort_at}"
    return f"{joint.name}.{joint.drive.rotors[0].name}" if joint.drive.rotors else None
