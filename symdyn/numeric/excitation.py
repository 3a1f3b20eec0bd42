"""Which directions of the model's parameters a recording does not excite, though another motion could."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.evidence import effective_count
from symdyn.numeric.noise_floor import independent_samples
from symdyn.numeric.regression import RANK_TOLERANCE
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

STATES = 400  # random ones, which excite all that can be
SPEED, ACCELERATION = 3.0, 10.0  # of them, SI units
UNKNOWN = 1.0  # standard error of a direction, in parts of its parameters' values
PART = 0.3  # of a direction that a parameter must have to be named


def unexcited(bench: Workbench, p: Array, names: Sequence[str], residual: Array, weight: Array) -> list[str]:
    """One sentence per direction of parameters that stays unknown to more than its own size.

    A direction that no motion excites (mass and arm of a pendulum) is the model's, and not told: those
    that random states do excite are compared. ``residual`` (K, n) of the fit sets the noise.
    """
    names = [name for name in names if p[bench.index[name]] != 0.0]
    if not names:
        return []
    size = np.abs(p[[bench.index[name] for name in names]])
    weighted = bench.columns(p, names) * weight[:, None] * size
    possible = _random_columns(bench, p, names) * size
    scale = np.linalg.norm(possible, axis=(0, 1)) + 1e-300
    _, s, vt = np.linalg.svd(possible.reshape(-1, len(names)) / scale, full_matrices=False)
    space = (vt[s > RANK_TOLERANCE * s.max(initial=0.0)] / scale).T
    space, _ = np.linalg.qr(space)
    _, reached, directions = np.linalg.svd(weighted.reshape(-1, len(names)) @ space, full_matrices=False)
    power = float(np.mean((residual * weight) ** 2))
    count = sum(effective_count(column, independent_samples(bench)) for column in residual.T)
    noise = np.sqrt(power * residual.size / max(count, 1.0))
    told = []
    for length, direction in zip(reached, directions, strict=True):
        if noise > UNKNOWN * length:
            parts = space @ direction
            named = [name for name, part in zip(names, parts, strict=True) if abs(part) >= PART * np.abs(parts).max()]
            together = " and ".join(named) if len(named) < 3 else f"{', '.join(named[:-1])} and {named[-1]} together"
            told.append(f"these recordings do not excite {together}: another motion would be needed to tell")
    return told


def _random_columns(bench: Workbench, p: Array, names: Sequence[str]) -> Array:
    """(STATES, n, k) at random states; the same ones every time."""
    rng = np.random.default_rng(0)
    n = bench.effort.shape[1]
    states = [rng.uniform(-top, top, (STATES, n)) for top in (np.pi, SPEED, ACCELERATION)]
    jacobian: Array = bench.kernel.inverse_dynamics_parameter_jacobian_p_batch(*states, p)
    return jacobian[:, :, [bench.index[name] for name in names]]
