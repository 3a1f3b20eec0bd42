"""The places of a robot: where an effect may attach."""

from __future__ import annotations

from collections.abc import Iterator

from symdyn.spec.field_units import motion_of
from symdyn.spec.records import Joint, Motion, Place, PlaceKind, Robot


def places(robot: Robot) -> tuple[Place, ...]:
    """Every place, joint by joint: the joint, then rotors, shafts and motor circuit of its drive."""
    return tuple(place for joint in robot.joints for place in joint_places(joint))


def joint_places(joint: Joint) -> Iterator[Place]:
    motion = motion_of(joint.kind)
    yield Place(joint.name, PlaceKind.JOINT, motion)
    if joint.drive is None:
        return
    for rotor in joint.drive.rotors:
        yield Place(f"{joint.name}.{rotor.name}", PlaceKind.INERTIA, motion)
    for shaft in joint.drive.shafts:
        yield Place(f"{joint.name}.{shaft.name}", PlaceKind.SHAFT, motion)
    if joint.drive.motor is not None:
        yield Place(f"{joint.name}.{joint.drive.motor.name}", PlaceKind.CIRCUIT, Motion.ELECTRICAL)
