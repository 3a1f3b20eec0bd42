"""Places that move rigidly with a joint: where the same effect would look the same in any recording."""

from __future__ import annotations

from collections.abc import Sequence

from symdyn.numeric.gearing import turns_with_joint
from symdyn.physics import catalogue
from symdyn.spec.places import joint_places, places
from symdyn.spec.records import Joint, PlaceKind, Robot


def rigid_group(joint: Joint, effect: str | None = None) -> tuple[str, ...]:
    """The joint and the rotors that are geared to it rigidly, of those where ``effect`` may attach.

    For machines whose coordinates are their joints: there every rotor turns with its joint, so that an
    effect at either is the same effort, its parameters scaled by the gear ratio.
    """
    kinds = {PlaceKind.JOINT, PlaceKind.INERTIA}
    law = catalogue()[effect] if effect else None
    return tuple(
        place.address
        for place in joint_places(joint)
        if place.kind in kinds and (law is None or (place.kind in law.attaches_to and place.motion in law.motions))
    )


def same_place(robot: Robot, address: str) -> tuple[str, ...]:
    """The address itself; of a rotor that is fixed to its joint the joint's, too, where hypotheses stand."""
    joints = (joint.name for joint in robot.joints if turns_with_joint(joint, address))
    return (address, *joints)


def elsewhere(robot: Robot, place: str, group: Sequence[str]) -> tuple[str, ...]:
    """Those of a group that are parts of the robot, and not geared rigidly to the place."""
    parts = {same_place(robot, part.address)[-1] for part in places(robot)} - {same_place(robot, place)[-1]}
    return tuple(dict.fromkeys(at for at in (same_place(robot, each)[-1] for each in group) if at in parts))
