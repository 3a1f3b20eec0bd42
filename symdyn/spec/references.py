"""What the servo loops of a robot follow: a number that is asked for, at the outermost loop of a joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.places import joint_places
from symdyn.spec.records import EffectSpec, Joint


def reference_units(
    joints: Sequence[Joint], effects: Sequence[EffectSpec], catalogue: Mapping[str, EffectSchema]
) -> dict[str, str]:
    """The SI unit of each reference, by the joint's name and by the place of its outermost loop, which comes first."""
    motions = {place.address: place.motion for joint in joints for place in joint_places(joint)}
    found: dict[str, str] = {}
    for effect in effects:
        unit, joint = catalogue[effect.type].reference, effect.at.partition(".")[0]
        if unit is not None and joint not in found:
            found[joint] = found[effect.at] = unit if isinstance(unit, str) else unit[motions[effect.at]]
    return found
