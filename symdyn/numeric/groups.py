"""Places that move rigidly with a joint: where the same effect would look the same in any recording."""

from __future__ import annotations

from symdyn.physics import catalogue
from symdyn.spec.places import joint_places
from symdyn.spec.records import Joint, PlaceKind


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
