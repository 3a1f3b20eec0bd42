"""Whether what swings was found for what it is: with three numbers it also passes for a filter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symdyn.numeric.beyond_noise import left_by_positions
from symdyn.numeric.explanation import joint_errors
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.leftover import leftover, variables
from symdyn.numeric.noise_floor import in_band, noise_density
from symdyn.numeric.rounding import left_by_steps
from symdyn.numeric.verdict import explained_share, that_matters

TELLS_ALL = 0.999  # of the structured mismatch, that what swings tells with all the rest: all but 3 % of its size


def merely_filters(after: Inquiry) -> str | None:
    """Why what swings was not to be found: it leaves something that is no noise, or took away no more than noise.

    An inertia behind a spring tells all that it does. Something else that it resembles, it tells in part, and it
    resembles much: with three numbers it is a filter.
    """
    case, current = after.case, after.current
    swinging = " and ".join(c.label for c, _ in current.found if c.swings)
    if not swinging:
        return None
    bare = case.explain(tuple(item for item in current.found if not item[0].swings), current)
    positions = np.maximum(left_by_steps(after)[1], left_by_positions(case.judge, bare.fit.p))
    noise = np.hypot(in_band(noise_density(case.judge, bare.fit.p), case.judge), positions)
    there = [case.joints.index(c.place.address) for c, _ in current.found if c.swings]
    if np.all(np.sqrt(np.mean(bare.heldout**2, axis=0))[there] <= noise[there]):
        return f"{swinging} fits best, and takes off no more than noise"
    left = leftover(
        (current.training, case.bench.motion),
        (current.heldout, case.judge.motion),
        variables(case.joints),
        dict(zip(case.joints, joint_errors(current.heldout, case.judge).tolist(), strict=True)),
        case.judge.samples_per_period,
    )
    hidden = joint_errors(case.left_by_sampling(current), case.judge).tolist()
    left = that_matters(left, after.findings, dict(zip(case.joints, hidden, strict=True)))
    errors = after.first.errors(after.given), case.errors(current)
    told = not left.structured or explained_share(left.unlike_noise, left, *errors) >= TELLS_ALL
    return None if told else f"{swinging} fits best, but not whole: it takes the place of something else"


def without_swinging(begun: Inquiry) -> Inquiry:
    kept = tuple(c for c in begun.setting.proposed if not c.swings)
    return replace(begun, setting=replace(begun.setting, proposed=kept))
