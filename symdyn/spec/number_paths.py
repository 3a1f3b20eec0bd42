"""Every number of a robot, with the key path at which its file holds it."""

from __future__ import annotations

from collections.abc import Iterator

from symdyn.spec.records import DHRow, Drive, Joint, Link, Monomial, Placement, Robot
from symdyn.spec.toml_positions import KeyPath

_MOMENTS = ("xx", "yy", "zz", "xy", "xz", "yz")


def number_paths(robot: Robot) -> Iterator[tuple[KeyPath, Monomial]]:
    """(key path, monomial) in the order of the records; numbers left to their default have a path too."""
    for i, component in enumerate(robot.gravity):
        yield ("robot", "gravity", i), component
    if robot.base is not None:
        yield from _position(robot.base, ("base", "placement"))
    for i, joint in enumerate(robot.joints):
        yield from _joint_numbers(joint, i)
    if robot.tool is not None:
        yield from _position(robot.tool.placement, ("tool", "placement"))
        yield from _link_numbers(robot.tool.link, ("tool",))
    for i, effect in enumerate(robot.effects):
        for key, value in effect.values:
            yield ("effect", i, key), value


def _joint_numbers(joint: Joint, i: int) -> Iterator[tuple[KeyPath, Monomial]]:
    path: KeyPath = ("joint", i)
    if isinstance(joint.placement, DHRow):
        row = joint.placement
        for column, constant in enumerate((row.theta, row.d, row.a, row.alpha)):
            yield ("dh", "rows", i, column), constant
    else:
        yield from _position(joint.placement, (*path, "placement"))
    yield from _link_numbers(joint.link, (*path, "link"))
    if joint.drive is not None:
        yield from _drive_numbers(joint.drive, (*path, "drive"))
    if joint.actuator is not None:
        yield (*path, "actuator", "gain"), joint.actuator.gain


def _position(placement: Placement, path: KeyPath) -> Iterator[tuple[KeyPath, Monomial]]:
    for axis, coordinate in enumerate(placement.position):
        yield (*path, "xyz", axis), coordinate


def _link_numbers(link: Link, path: KeyPath) -> Iterator[tuple[KeyPath, Monomial]]:
    yield (*path, "mass"), link.mass
    for axis, coordinate in enumerate(link.com):
        yield (*path, "com", axis), coordinate
    for entry, moment in zip(_MOMENTS, link.inertia, strict=True):
        yield (*path, "inertia", entry), moment


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
