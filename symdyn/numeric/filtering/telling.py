"""An effect that was found, as it is told: with its numbers, its group of places, and its rivals."""

from __future__ import annotations

from symdyn.numeric.filtering.conclude import parameters
from symdyn.numeric.filtering.judged import Explanation, Step, alike
from symdyn.numeric.filtering.model import Model
from symdyn.numeric.filtering.stiff import rigid_with
from symdyn.numeric.findings import Alternative, Finding, Rival
from symdyn.numeric.gearing import turns_with_joint
from symdyn.numeric.groups import rigid_group


def finding(model: Model, before: Explanation, chosen: Step, tried: tuple[Step, ...]) -> Finding:
    candidate = chosen.score.candidate
    own = candidate.effect, candidate.place.address
    tried = tuple(s for s in tried if (s.score.candidate.effect, s.score.candidate.place.address) != own)
    same = alike(chosen, tried)
    elsewhere = [s.score.candidate.place.address for s in same if s.score.candidate.effect == candidate.effect]
    elsewhere += rigid_with(model, chosen.after, candidate.place.address, candidate.effect)
    group = with_fixed_rotors(model, (candidate.place.address, *elsewhere, *chosen.group), candidate.effect)
    rivals = tuple(
        Rival(s.score.candidate.effect, s.score.candidate.place.address, s.p_value)
        for s in same
        if s.score.candidate.effect != candidate.effect
    )
    here = {(candidate.effect, at) for at in group}
    others = tuple(
        Alternative(s.score.candidate.effect, s.score.candidate.place.address, s.after.heldout)
        for s in tried
        if s not in same and (s.score.candidate.effect, s.score.candidate.place.address) not in here
    )
    return Finding(
        candidate.effect,
        candidate.title,
        candidate.place.address,
        parameters(model, chosen.after, candidate),
        before.heldout,
        chosen.after.heldout,
        chosen.p_value,
        rivals,
        others,
        group,
        chosen.gain,
    )


def with_fixed_rotors(model: Model, places: tuple[str, ...], effect: str) -> tuple[str, ...]:
    """A rotor that is fixed to its joint is one place with it."""
    found = list(dict.fromkeys(places))
    for joint in model.robot.joints:
        if joint.name in places:
            found += [place for place in rigid_group(joint, effect) if turns_with_joint(joint, place)]
    return tuple(found)
