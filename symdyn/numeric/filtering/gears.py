"""How far the parts of a machine go with its joints, and how fast they usually do, by what was recorded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.gearing import TACHOMETER, coordinate_shown, joint_of, motor_rotor, number, reach
from symdyn.numeric.recording import ChannelKey, Recording
from symdyn.spec.records import Quantity, Robot

Array = NDArray[np.float64]

BASELINE = 0.02  # s over which a position is differenced: no noise is blown up
UNKNOWN = 1.0  # speed of a joint of which nothing tells it


def per_joint(robot: Robot, addresses: Sequence[str]) -> Array:
    """(n,) how far each coordinate goes with its joint, where nothing twists: its gear ratio, or 1."""
    return np.array([reach(robot, at) for at in addresses])


def usual_speeds(robot: Robot, recording: Recording, addresses: Sequence[str]) -> Array:
    """(n,) root mean square speed of each coordinate: its own, or that of the fastest part of its joint, geared.

    A joint of which neither position nor speed was measured goes by its tachometer, or by its motor's voltage, which
    the back-EMF balances at full speed; one of which nothing was, like the fastest of the others.
    """
    found: dict[str, float] = {}
    for told in (_moving, _turning, _driven):
        surer = set(found)
        for key, values in recording.channels.items():
            if key[0] is Quantity.PARAMETER:
                continue
            address, speed = told(robot, key, values, recording.sample_time)
            joint = address.partition(".")[0]
            if speed > 0.0 and joint not in surer:
                found[joint] = max(found.get(joint, 0.0), speed / float(np.abs(per_joint(robot, [address])[0])))
    fallback = max(found.values(), default=UNKNOWN)
    by_joint = np.array([found.get(at.partition(".")[0], fallback) for at in addresses])
    return np.asarray(np.abs(per_joint(robot, addresses)) * by_joint)


def _moving(robot: Robot, key: ChannelKey, values: Array, step: float) -> tuple[str, float]:
    """A coordinate and its speed, by a channel of its position or speed; 0 where it is none."""
    if key[0] is Quantity.POSITION:
        span = max(1, int(BASELINE / step))
        at, scale = coordinate_shown(robot, key)
        return at, abs(scale) * float(np.std(values[span:] - values[:-span])) / (span * step)
    if key[0] is Quantity.VELOCITY:
        at, scale = coordinate_shown(robot, key)
        return at, abs(scale) * float(np.std(values))
    return key[1], 0.0


def _turning(robot: Robot, key: ChannelKey, values: Array, step: float) -> tuple[str, float]:
    """By a tachometer's voltage."""
    sensor = next((e for e in robot.effects if e.type == TACHOMETER and e.at == key[1]), None)
    constant = number(robot, dict(sensor.values)["constant"]) if sensor is not None else 0.0
    return key[1], float(np.std(values)) / abs(constant) if key[0] is Quantity.VOLTAGE and constant else 0.0


def _driven(robot: Robot, key: ChannelKey, values: Array, step: float) -> tuple[str, float]:
    """By its motor's voltage, which the back-EMF balances at full speed."""
    joint = joint_of(robot, key[1])
    motor = joint.drive.motor if joint.drive is not None else None
    constant = number(robot, motor.back_emf_constant) if motor is not None else 0.0
    at = motor_rotor(joint) or joint.name
    return at, float(np.std(values)) / abs(constant) if key[0] is Quantity.VOLTAGE and constant else 0.0
