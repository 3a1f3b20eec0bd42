"""The places of a robot: where an effect may attach."""

from __future__ import annotations

from collections.abc import Iterator

from symdyn.spec.field_units import motion_of
from symdyn.spec.records import Joint, Motion, Place, PlaceKind, Robot


def places(robot: Robot) -> tuple[Place, ...]:
    """Every place, joint by joint: the joint, then rotors, shafts and motor circuit of its drive."""
    return tuple(place for joint in robot.joints for place in joint_places(joint))


def joint_places(joint: Joint) -> Iterator[Place]:
    yield Place(joint.name, PlaceKind.JOINT, motion_of(joint.kind))
    if joint.drive is None:
        return
    for rotor in joint.drive.rotors:  # a drive turns, whatever its joint does
        yield Place(f"{joint.name}.{rotor.name}", PlaceKind.INERTIA, Motion.ROTATIONAL)
    for shaft in joint.drive.shafts:
        yield Place(f"{joint.name}.{shaft.name}", PlaceKind.SHAFT, Motion.ROTATIONAL)
    if joint.drive.motor is not None:
        yield Place(f"{joint.name}.{joint.drive.motor.name}", PlaceKind.CIRCUIT, Motion.ELECTRICAL)
