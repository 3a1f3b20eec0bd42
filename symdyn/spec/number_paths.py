"""Every number of a robot, with the key path at which its file holds it."""

from __future__ import annotations

from collections.abc import Iterator

from symdyn.spec.records import Drive, Joint, Monomial, Robot
from symdyn.spec.toml_positions import KeyPath

_MOMENTS = ("xx", "yy", "zz", "xy", "xz", "yz")


def number_paths(robot: Robot) -> Iterator[tuple[KeyPath, Monomial]]:
    """(key path, monomial) in the order of the records; numbers left to their default have a path too."""
    for i, component in enumerate(robot.gravity):
        yield ("robot", "gravity", i), component
    for i, joint in enumerate(robot.joints):
        yield from _joint_numbers(joint, i)
    for i, effect in enumerate(robot.effects):
        for key, value in effect.values:
            yield ("effect", i, key), value


def _joint_numbers(joint: Joint, i: int) -> Iterator[tuple[KeyPath, Monomial]]:
    for column, constant in enumerate((joint.dh.theta, joint.dh.d, joint.dh.a, joint.dh.alpha)):
        yield ("dh", "rows", i, column), constant
    path: KeyPath = ("joint", i)
    yield (*path, "link", "mass"), joint.link.mass
    for axis, coordinate in enumerate(joint.link.com):
        yield (*path, "link", "com", axis), coordinate
    for entry, moment in zip(_MOMENTS, joint.link.inertia, strict=True):
        yield (*path, "link", "inertia", entry), moment
    if joint.drive is not None:
        yield from _drive_numbers(joint.drive, (*path, "drive"))
    if joint.actuator is not None:
        yield (*path, "actuator", "gain"), joint.actuator.gain


def _drive_numbers(drive: Drive, path: KeyPath) -> Iterator[tuple[KeyPath, Monomial]]:
    yield (*path, "ratio"), drive.ratio
    for i, rotor in enumerate(drive.rotors):
        yield (*path, "rotors", i, "inertia"), rotor.inertia
    for i, shaft in enumerate(drive.shafts):
        yield (*path, "shafts", i, "stiffness"), shaft.stiffness
        yield (*path, "shafts", i, "damping"), shaft.damping
    if drive.motor is not None:
        yield (*path, "motor", "resistance"), drive.motor.resistance
        yield (*path, "motor", "inductance"), drive.motor.inductance
        yield (*path, "motor", "torque_constant"), drive.motor.torque_constant
        yield (*path, "motor", "back_emf_constant"), drive.motor.back_emf_constant
