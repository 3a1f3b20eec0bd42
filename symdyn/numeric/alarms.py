"""What a diagnosis warns of beside its findings: parameters that went too far, gravity that is none, even noise."""

from __future__ import annotations

import math
from collections.abc import Sequence

from symdyn.numeric.beyond_noise import Beyond
from symdyn.numeric.candidates import GRAVITY, bounds
from symdyn.numeric.explanation import Case, Explanation
from symdyn.numeric.findings import Remaining
from symdyn.numeric.leftover import is_loud
from symdyn.spec.monomials import value_of
from symdyn.spec.records import Robot

LITTLE = 0.1  # part of gravity: that much may be left where a weight is balanced
ON_EARTH = (9.764, 9.834)  # m/s^2, the least and the most (Hirt et al. 2013)
OFF = 0.01  # of it
SURE = 3.0  # standard errors


def absorbing(case: Case, final: Explanation) -> list[str]:
    """Parameters that ran to a bound, or far from the model's value: they are taking up structure that it lacks.

    Of all values that a recording cannot tell apart, a fit takes those nearest to the model's. Where those are far,
    no near ones would do.
    """
    limits, told = bounds(case.robot), []
    for name in case.far(final.fit):
        value, given = (float(p[case.bench.index[name]]) for p in (final.fit.p, case.bench.kernel.values))
        if name in limits and value <= limits[name][0]:
            told.append(f"{name} ran to its lower bound {limits[name][0]:.3g}: it may be absorbing missing structure")
        else:
            told.append(f"{name} went from {given:.3g} to {value:.3g}: it may be absorbing missing structure")
    for candidate, _ in final.found:
        for schema in case.bounded(candidate, final):
            told.append(f"{schema.name} of {candidate.label} ran to its bound: it may be absorbing missing structure")
    return told


def weightless(given: Robot, case: Case, final: Explanation) -> list[str]:
    """Gravity that all but vanished: what was found says so of the arm's own weight, not of what it carries."""
    names = [name for r in case.revised if r.effect == GRAVITY for name in r.names.values()]
    numbers = {p.name: p.value for p in given.parameters}
    before = math.hypot(*(value_of(m, numbers) or 0.0 for m in given.gravity))
    after = math.hypot(*(float(final.fit.p[case.bench.index[name]]) for name in names))
    if not names or not after < LITTLE * before:
        return []
    return [
        f"{100 * after / before:.0f} % of gravity is left: the arm is balanced, or its efforts leave its weight out; "
        f"where gravity is known to act, hold it (`--hold {GRAVITY}`): what carries the weight is looked for then"
    ]


def unearthly(case: Case, final: Explanation) -> list[str]:
    """Gravity of a size that is nowhere on Earth: its direction may be as told, its size stands for something else."""
    names = [name for r in case.revised if r.effect == GRAVITY for name in r.names.values()]
    told = case.model_parameters(final)
    size = math.hypot(*(told[name].value for name in names))
    error = math.hypot(*(told[name].se or 0.0 for name in names))
    if not names or not all(abs(size - g) > max(SURE * error, OFF * g) for g in ON_EARTH):
        return []
    return [
        f"no place on Earth has a gravity of {size:.4g} +- {error:.1g} m/s^2: lengths of the model, or masses that are "
        "held, may be off by that"
    ]


def even(beyond: Sequence[Beyond], joints: Sequence[str], remaining: Remaining) -> list[str]:
    """What is more than noise, and as even as noise: a recording cannot say which it is."""
    if remaining.structured:
        return []
    return [
        f"what is left at {joint} is {of.times:.2g} times what the sensors' noise at higher frequencies would leave, "
        "and the same wherever the machine is: a sensor that filters its noise, or a disturbance from outside"
        for joint, of in zip(joints, beyond, strict=True)
        if is_loud(of, len(beyond))
    ]
