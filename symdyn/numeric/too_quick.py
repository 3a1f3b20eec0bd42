"""Whether a motion is too quick for derivatives over its samples: what they leave would be taken for physics."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.beyond_noise import left_by_positions
from symdyn.numeric.explanation import joint_errors
from symdyn.numeric.observation import Observation
from symdyn.numeric.sampling import left_at, left_by_derivatives
from symdyn.numeric.setting import LEAST_TRAVEL
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

MUCH = 0.02  # of the effort: less than the laws that one looks for tell of it
BEYOND = 2.0  # times what noise makes of it
MOST = 0.5  # of the motion's power


def too_quick(bench: Workbench, p: Array, joints: Sequence[str]) -> list[str]:
    """What people should know where derivatives leave much of an effort; nothing, if they do not.

    What the noise of positions leaves that way is no motion. What a motion leaves is in all numbers, however loud the
    noise is beside it.

    Nor may what is differentiated leave out most of all motion: no noise floor is seen below a motion that goes up to
    half the rate, and what is slow in it is taken for all there is.
    """
    left = left_by_derivatives(bench, p)
    beyond = np.sqrt(np.mean(left**2, axis=0)) > BEYOND * left_by_positions(bench, p, left_at)
    parts = joint_errors(left, bench)
    doubts = [
        f"{joint} moves too quickly for its samples: derivatives alone leave {100.0 * part:.0f} % of its effort, and "
        "what is found or not found in the rest may be wrong; sample more often"
        for joint, part, more in zip(joints, parts, beyond, strict=True)
        if more and part > MUCH
    ]
    unseen = _left_out(bench.observation)
    if not np.all(unseen > MOST):
        return doubts
    return [
        *doubts,
        f"at least {100.0 * float(unseen.min()):.0f} % of the motion's power is quicker than the "
        f"{bench.observation.cutoff:.3g} Hz below which it was looked at; sample more often",
    ]


def _left_out(o: Observation) -> Array:
    """(n,) part of each motion's power, without the noise of its sensor, that is not in what is differentiated.

    Of a joint that stands nothing is.
    """
    motion = np.where(np.ptp(o.measured, axis=0) >= LEAST_TRAVEL, np.var(o.measured, axis=0), np.inf)
    noise = 0.5 * o.rate * o.noise
    return np.asarray((np.mean((o.measured - o.q) ** 2, axis=0) - noise) / motion)
