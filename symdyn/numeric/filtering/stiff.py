"""Parts that are rigid to each other as far as samples show: their resonance is above half the sampling rate."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.filtering.judged import Explanation
from symdyn.numeric.filtering.likelihood import MLFit
from symdyn.numeric.filtering.model import Model
from symdyn.numeric.gearing import shaft_end
from symdyn.physics import catalogue, with_play
from symdyn.physics.effect import MOVING
from symdyn.spec.places import places

NYQUIST = 0.5  # periods per sample
TWISTED = 1e-6  # rad between any two ends, or m


def resonance(model: Model, fitted: MLFit, one: str, other: str) -> float:
    """Hz, undamped, of two coordinates against each other, as if nothing else held them."""
    kernel = model.kernel
    n = len(kernel.coordinates)
    x = np.ones(len(kernel.states))  # in motion: friction does not turn
    x[:n] = TWISTED * np.pi ** np.arange(n)  # where a spring with a gap of no width is one
    p = fitted.p[: len(kernel.parameters)]
    slope = np.asarray(kernel.state_derivative_state_jacobian_p(x, np.zeros(len(kernel.inputs)), p))[n : 2 * n, :n]
    i, j = (kernel.coordinates.index(at) for at in (one, other))
    geared = float(model.training.per_joint[i] / model.training.per_joint[j])
    return math.sqrt(max(0.0, float(slope[i, j] / geared + slope[j, i] * geared))) / (2.0 * math.pi)


def beyond_sampling(model: Model, frequency: float) -> bool:
    """Whether samples come too slowly to show a swing of that frequency in Hz."""
    return frequency * float(np.nanmedian(model.training.steps)) > NYQUIST


def rigid_with(model: Model, of: Explanation, place: str, effect: str) -> tuple[str, ...]:
    """Where else the same effect would look the same: parts on stiff shafts from there, the nearest first.

    Whether a force pushes one of them or the other only twists what is between them, quicker than samples come, and by
    less than steps of a filter are off by. A shaft with play is not stiff, and one with an encoder at both ends shows
    its twist.
    """
    found, pairs = [place], list(unseen_shafts(model, of).values())
    for at in found:  # grows on the way
        for pair in pairs:
            other = next((end for end in pair if end != at), at)
            if at in pair and other not in found:
                found.append(other)
    law = catalogue()[effect]
    fits = {p.address for p in places(model.robot) if p.kind in law.attaches_to and p.motion in law.motions}
    return tuple(at for at in found[1:] if at in fits)


def unseen_shafts(model: Model, of: Explanation) -> dict[str, tuple[str, str]]:
    """The ends of shafts whose twist no sample shows: without play, stiff, no encoder at one end or both."""
    coordinates = model.kernel.coordinates
    shown = {coordinates[i] for i in model.training.index if i < len(coordinates)}
    loose = {e.at for e in model.robot.effects if e.type in with_play()}
    loose |= {c.place.address for c, _ in of.found if c.effect in with_play()}
    ends = {
        f"{joint.name}.{shaft.name}": (shaft_end(joint, shaft.start), shaft_end(joint, shaft.end))
        for joint in model.robot.joints
        for shaft in (joint.drive.shafts if joint.drive else ())
    }
    return {
        at: pair
        for at, pair in ends.items()
        if at not in loose and not shown.issuperset(pair) and beyond_sampling(model, resonance(model, of.fit, *pair))
    }


def that_show(model: Model, of: Explanation, hypotheses: Sequence[Candidate]) -> list[Candidate]:
    """Without laws of what moves (friction, springs) at such shafts: they act on a twist that no sample shows.

    What they gain is chance, and a filter of dry friction there chatters. Play, an error of the transmission and
    friction by its load are more than that twist.
    """
    unseen = unseen_shafts(model, of)
    return [c for c in hypotheses if c.place.address not in unseen or not catalogue()[c.effect].attaches_to >= MOVING]
