"""Whether a motion is too quick for derivatives over its samples: what they leave would be taken for physics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.beyond_noise import left_by_positions
from symdyn.numeric.explanation import joint_errors
from symdyn.numeric.noise_floor import in_band, noise_density
from symdyn.numeric.sampling import left_by_derivatives
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

MUCH = 0.02  # of the effort: less than the laws that one looks for tell of it
BEYOND = 2.0  # times what the noise of the sensors leaves


def too_quick(bench: Workbench, p: Array, joints: Sequence[str]) -> dict[str, float]:
    """Joints, and the part of their efforts that derivatives leave, where that is much, and more than noise."""
    left = left_by_derivatives(bench, p)
    noise = np.hypot(in_band(noise_density(bench, p), bench), left_by_positions(bench, p))
    beyond = np.sqrt(np.mean(left**2, axis=0)) > BEYOND * noise
    parts = joint_errors(left, bench)
    return {joint: float(part) for joint, part, more in zip(joints, parts, beyond, strict=True) if more and part > MUCH}


def doubtful(parts: Mapping[str, float]) -> list[str]:
    """What people should know, where a filter could not be asked instead."""
    return [
        f"{joint} moves too quickly for its samples: derivatives alone leave {100.0 * part:.0f} % of its effort, and "
        "what is found or not found in the rest may be wrong; sample more often"
        for joint, part in parts.items()
    ]
