"""What inverse dynamics sees of a machine: joints that are driven, without circuits and with rigid transmissions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from symdyn.compiler import parametric_kernel
from symdyn.emit.kernel import Kernel
from symdyn.numeric.gearing import coordinate_shown, effort_shown, joint_of
from symdyn.numeric.recording import ChannelKey, Recording, frozen
from symdyn.spec.places import places
from symdyn.spec.records import Drive, Joint, Quantity, Robot, Side

MOTIONS = (Quantity.POSITION, Quantity.VELOCITY)


def mechanics(robot: Robot) -> Robot:
    """Rotors fixed to their joints; no shafts, no circuits, and no effects at either."""
    return with_joints(robot, tuple(replace(joint, drive=_rigid(joint.drive)) for joint in robot.joints))


def mechanical_kernel(robot: Robot) -> Kernel:
    """Of the ``mechanics``, parameters left free."""
    return parametric_kernel(mechanics(robot))


def with_joints(robot: Robot, joints: tuple[Joint, ...]) -> Robot:
    """And without effects at places that these do not have; the robot itself where nothing changes."""
    if joints == robot.joints:
        return robot
    changed = replace(robot, joints=joints)
    there = {place.address for place in places(changed)}
    gone = {place.address for place in places(robot)} - there
    return replace(changed, effects=tuple(effect for effect in robot.effects if effect.at not in gone))


def soft_rotors(robot: Robot) -> tuple[str, ...]:
    """Addresses of rotors with a coordinate of their own."""
    drives = [(joint.name, joint.drive) for joint in robot.joints if joint.drive is not None]
    return tuple(f"{joint}.{r.name}" for joint, drive in drives for r in drive.rotors if not r.fixed_to_joint)


def _rigid(drive: Drive | None) -> Drive | None:
    if drive is None:
        return None
    rotors = tuple(replace(rotor, fixed_to_joint=True) for rotor in drive.rotors)
    return replace(drive, rotors=rotors, shafts=(), motor=None, effort_at="")


def at_joints(robot: Robot, recording: Recording) -> Recording:
    """With what the motors' side of gears shows told as the joints' own, where the joint's side shows nothing.

    A position of the motor is the joint's times the ratio; an effort of the motor, that over the ratio. Volts and
    amperes stay: an actuator's gain is that to the joint's effort.
    """
    rigid = mechanics(robot)
    found: dict[ChannelKey, NDArray[np.float64]] = {}
    geared: dict[ChannelKey, NDArray[np.float64]] = {}
    for key, values in recording.channels.items():
        if key[0] is Quantity.PARAMETER:
            found[key] = values
            continue
        at, factor = (coordinate_shown if key[0] in MOTIONS else effort_shown)(rigid, key)
        joint = joint_of(rigid, at)
        beside = key[0] not in (*MOTIONS, Quantity.EFFORT) or key[2] is Side.OUTPUT
        if beside or at != joint.name or key[1:] == (at, Side.LINK):
            found[key] = values
        else:
            geared.setdefault((key[0], at, Side.LINK), frozen(factor * values))
    return replace(recording, channels=MappingProxyType({**geared, **found})) if geared else recording


def untested(robot: Robot, tested: Robot) -> tuple[str, ...]:
    """What is to be said of parts that the machine has and what was ``tested`` of it has not."""
    return tuple(told for pair in zip(robot.joints, tested.joints, strict=True) for told in _untested(*pair))


def _untested(joint: Joint, without: Joint) -> Iterator[str]:
    drive, rest = joint.drive, without.drive
    if drive is None or rest is None:
        return
    if drive.motor is not None and rest.motor is None:
        yield f"the circuit of {joint.name} is not tested: its motor is driven by what was recorded behind it"
    if any(not rotor.fixed_to_joint for rotor in drive.rotors) and all(rotor.fixed_to_joint for rotor in rest.rotors):
        yield f"the transmission of {joint.name} is taken for rigid, and its shafts are not tested"
