"""Motors of which the current was recorded: what it exerts, in place of a circuit that no voltage tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.gearing import TACHOMETER, gear_ratio, number, turns_with_joint
from symdyn.numeric.mechanics import with_joints
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Actuator, Joint, Monomial, Quantity, Robot

Array = NDArray[np.float64]


def current_of(joint: Joint, recording: Recording) -> Array | None:
    """(N,) A, of the joint's motor; None where there is no motor, or its current was not recorded."""
    for (quantity, address, _), values in recording.channels.items():
        if quantity is Quantity.CURRENT and address in _addresses(joint):
            return values
    return None


def has_voltage(robot: Robot, joint: Joint, recording: Recording) -> bool:
    """Whether the voltage of the joint's motor was recorded: that of a tachometer on its shaft is another."""
    sensors = {effect.at for effect in robot.effects if effect.type == TACHOMETER}
    keys = [key for key in recording.channels if key[0] is Quantity.VOLTAGE]
    return any(address in _addresses(joint) and address not in sensors for _, address, _ in keys)


def input_of(joint: Joint) -> Quantity | None:
    """What an actuator is given; None where there is none, or its input has another unit."""
    units = {"V": Quantity.VOLTAGE, "A": Quantity.CURRENT}
    return None if joint.actuator is None else units.get(joint.actuator.input_unit)


def effort_by_current(robot: Robot, joint: Joint, recording: Recording) -> Array | None:
    """(N,) effort that the motor's current gives a joint that its rotor is fixed to; None as ``current_of``."""
    current, drive = current_of(joint, recording), joint.drive
    if current is None or drive is None or drive.motor is None:
        return None
    return number(robot, drive.motor.torque_constant) * gear_ratio(robot, joint) * current


def driven_by_current(robot: Robot, recordings: Sequence[Recording]) -> Robot:
    """The robot with torques in proportion to currents in place of circuits, where every recording is without voltage.

    Effects of such a circuit (its amplifier's) are gone with it.
    """
    changed = (_driven(joint) if _imposed(robot, joint, recordings) else joint for joint in robot.joints)
    return with_joints(robot, tuple(changed))


def _imposed(robot: Robot, joint: Joint, recordings: Sequence[Recording]) -> bool:
    return all(
        current_of(joint, recording) is not None
        and not has_voltage(robot, joint, recording)
        and not recording.has(Quantity.EFFORT, joint.name)
        for recording in recordings
    )


def _addresses(joint: Joint) -> tuple[str, ...]:
    """By which a channel may name the motor; none where there is no motor."""
    motor = joint.drive.motor if joint.drive is not None else None
    return () if motor is None else (joint.name, f"{joint.name}.{motor.at}", f"{joint.name}.{motor.name}")


def _driven(joint: Joint) -> Joint:
    drive = joint.drive
    assert drive is not None
    assert drive.motor is not None
    gain, at = drive.motor.torque_constant, drive.motor.at
    if turns_with_joint(joint, f"{joint.name}.{at}"):
        gain, at = _product(gain, drive.ratio), ""
    return replace(joint, drive=replace(drive, motor=None, effort_at=at), actuator=Actuator(gain, "A"))


def _product(one: Monomial, other: Monomial) -> Monomial:
    powers: dict[str, int] = {}
    for name, power in (*one.factors, *other.factors):
        powers[name] = powers.get(name, 0) + power
    return Monomial(one.coefficient * other.coefficient, tuple((n, p) for n, p in powers.items() if p))
