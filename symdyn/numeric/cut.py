"""The parts that a torque sensor between a drive and its joint cuts a machine into: what lies beyond it, and the drive.

What the sensor shows is the effort of all beyond it, which has nothing of the rotors and the friction before it. The
drive is a rotor by itself, which its motor drives and that effort, over the ratio, brakes.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.circuits import effort_by_current, input_of
from symdyn.numeric.gearing import TACHOMETER, gear_ratio, motor_rotor, number
from symdyn.numeric.mechanics import at_joints, with_joints
from symdyn.numeric.reading import READERS
from symdyn.numeric.recording import ChannelKey, Recording, frozen
from symdyn.physics import catalogue
from symdyn.spec.records import (
    ZERO,
    Drive,
    Joint,
    JointKind,
    Link,
    Monomial,
    PlaceKind,
    Placement,
    Quantity,
    Robot,
    Side,
)

Array = NDArray[np.float64]


APART = "__"  # in the name of a rotor that is a joint here
OF_INPUT = frozenset(READERS) - {"encoder"}


@dataclass(frozen=True, slots=True)
class Part:
    """All beyond the torque sensors of the joints ``sensed`` (of none: the whole); or the ``drive`` of one of them."""

    sensed: tuple[str, ...] = ()
    drive: str | None = None
    at_joint: bool = False  # whether the input of that joint is its effort, not a voltage or a rotor's effort

    def of(self, robot: Robot) -> Robot:
        """What this part is of a robot: a robot, too, whose text is still the whole one's."""
        if self.drive is not None:
            return _alone(robot, next(joint for joint in robot.joints if joint.name == self.drive))
        bare = (replace(j, drive=None, actuator=None) if j.name in self.sensed else j for j in robot.joints)
        beyond = with_joints(robot, tuple(bare))
        effects = tuple(e for e in beyond.effects if e.at not in self.sensed or e.type not in OF_INPUT)
        return replace(beyond, effects=effects) if effects != beyond.effects else beyond

    def seen(self, robot: Robot, recording: Recording) -> Recording:
        """What a recording of the whole ``robot`` shows of this part."""
        if not self.sensed:
            return recording
        shown = at_joints(robot, without_sensors(recording, self.sensed))
        if self.drive is None:
            sensors = {
                (Quantity.EFFORT, j, Side.LINK): recording.channels[sensor_of(recording, j)] for j in self.sensed
            }
            rest = {key: values for key, values in shown.channels.items() if not _is_of_drive(key, self.sensed)}
            return replace(recording, channels=MappingProxyType(rest | sensors))
        joint = next(joint for joint in robot.joints if joint.name == self.drive)
        rotor, ratio = _as_joint(rotor_of(joint) or ""), gear_ratio(robot, joint)
        effort = motor_effort(robot, joint, shown)
        assert effort is not None
        turned = _turned(recording, rotor_of(joint) or "", ratio * shown.channel(Quantity.POSITION, joint.name))
        channels = {
            (Quantity.POSITION, rotor, Side.LINK): turned,
            (Quantity.EFFORT, rotor, Side.LINK): effort / ratio,
            (Quantity.EFFORT, rotor, Side.OUTPUT): recording.channels[sensor_of(recording, joint.name)] / ratio,
        }
        return replace(recording, channels=MappingProxyType({key: frozen(values) for key, values in channels.items()}))

    def has(self, effect: str, place: str) -> bool:
        """Whether an effect that is found at a joint of this part has a place in the whole robot.

        The input of a joint is what its motor gives: what a torque sensor shows is none.
        """
        if effect in OF_INPUT:
            return place not in self.sensed and (self.drive is None or self.at_joint)
        return self.drive is None or PlaceKind.INERTIA in catalogue()[effect].attaches_to

    def place(self, effect: str, address: str) -> str:
        """Where the whole robot has an effect of this part."""
        return self.drive if self.drive is not None and effect in OF_INPUT else self.named(address)

    def named(self, text: str) -> str:
        """A text in which places of this part are called as they are in the whole robot."""
        if self.drive is None:
            return text
        beside = rf"{re.escape(self.drive)}{APART}[\w-]+\.(?=\w)"  # another rotor of the drive
        return re.sub(beside, f"{self.drive}.", text).replace(f"{self.drive}{APART}", f"{self.drive}.")


UNCUT = Part()


def sensor_of(recording: Recording, joint: str) -> ChannelKey:
    """The channel of the effort at the output of a joint's drive."""
    output = (Quantity.EFFORT, joint, Side.OUTPUT)
    return output if output in recording.channels else (Quantity.EFFORT, joint, Side.LINK)


def without_sensors(recording: Recording, sensed: Sequence[str]) -> Recording:
    """The rest of what was recorded."""
    sensors = {sensor_of(recording, joint) for joint in sensed}
    rest = {key: values for key, values in recording.channels.items() if key not in sensors}
    return replace(recording, channels=MappingProxyType(rest))


def _is_of_drive(key: ChannelKey, sensed: Sequence[str]) -> bool:
    """Whether a channel shows what a drive alone does: all but the motion of its joint."""
    quantity, address, side = key
    joint = address.partition(".")[0]
    moves = address == joint and side is Side.LINK and quantity in (Quantity.POSITION, Quantity.VELOCITY)
    return joint in sensed and not moves


def _turned(recording: Recording, rotor: str, otherwise: Array) -> Array:
    """(N,) by the motor's own encoder, where there is one."""
    joint = rotor.partition(".")[0]
    own = (
        (Quantity.POSITION, joint, Side.MOTOR),
        (Quantity.POSITION, rotor, Side.LINK),
        (Quantity.POSITION, rotor, Side.MOTOR),
    )
    return next((recording.channels[key] for key in own if key in recording.channels), otherwise)


def motor_effort(robot: Robot, joint: Joint, shown: Recording) -> Array | None:
    """(N,) what the motor exerts, at the joint."""
    if shown.has(Quantity.EFFORT, joint.name):
        return shown.channel(Quantity.EFFORT, joint.name)
    by_current = effort_by_current(robot, joint, shown)
    if by_current is not None or joint.actuator is None or joint.drive is None:
        return by_current
    wanted = input_of(joint)
    if wanted is None or not shown.has(wanted, joint.name):
        return None
    geared = gear_ratio(robot, joint) if joint.drive.effort_at else 1.0
    return np.asarray(geared * number(robot, joint.actuator.gain) * shown.channel(wanted, joint.name))


def rotor_of(joint: Joint) -> str | None:
    """The rotor by which a drive is called: that which its motor turns, or else the first; None where it has none."""
    rotors = () if joint.drive is None else tuple(f"{joint.name}.{rotor.name}" for rotor in joint.drive.rotors)
    return next((at for at in (motor_rotor(joint), *rotors) if at in rotors), None)


def _as_joint(rotor: str) -> str:
    return rotor.replace(".", APART)


def _alone(robot: Robot, joint: Joint) -> Robot:
    """The rotors of a drive, turning together about an axis that stands."""
    drive, address = joint.drive, rotor_of(joint)
    assert drive is not None
    assert address is not None
    turning = next(rotor for rotor in drive.rotors if f"{joint.name}.{rotor.name}" == address)
    others = tuple(replace(rotor, fixed_to_joint=True) for rotor in drive.rotors if rotor is not turning)
    link = Link(inertia=(ZERO, ZERO, turning.inertia, ZERO, ZERO, ZERO))
    with_it = Drive(Monomial(1), others, (), None) if others else None
    name = _as_joint(address)
    of_input = [replace(e, at=name) for e in robot.effects if e.at == joint.name and e.type in OF_INPUT]
    there = {f"{joint.name}.{rotor.name}": f"{name}.{rotor.name}" for rotor in others} | {address: name}
    return replace(
        robot,
        gravity=(ZERO, ZERO, ZERO),
        joints=(Joint(name, JointKind.REVOLUTE, Placement(), link, with_it),),
        effects=(
            *of_input,
            *(replace(e, at=there[e.at]) for e in robot.effects if e.at in there and e.type != TACHOMETER),
        ),
        base=None,
        tool=None,
    )
