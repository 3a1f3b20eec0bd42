"""Which directions of the model's parameters a recording does not excite, though another motion could."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.decomposition import svd
from symdyn.numeric.evidence import effective_count
from symdyn.numeric.noise_floor import independent_samples
from symdyn.numeric.regression import RANK_TOLERANCE
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

STATES = 400  # random ones, which excite all that can be
SPEED, ACCELERATION = 3.0, 10.0  # of them, SI units
UNKNOWN = 1.0  # standard error of a direction, in parts of its parameters' values
PART = 0.3  # of the most affected parameter's share that another must have to be named
MOST = 8  # parameters named


def unexcited(bench: Workbench, p: Array, names: Sequence[str], residual: Array, weight: Array) -> list[str]:
    """A sentence on the directions of parameters that stay unknown to more than their own size, if there are any.

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
    _, s, vt = svd(possible.reshape(-1, len(names)) / scale, full_matrices=False)
    space = (vt[s > RANK_TOLERANCE * s.max(initial=0.0)] / scale).T
    space, _ = np.linalg.qr(space)
    _, reached, directions = svd(weighted.reshape(-1, len(names)) @ space, full_matrices=False)
    power = float(np.mean((residual * weight) ** 2))
    count = sum(effective_count(column, independent_samples(bench)) for column in residual.T)
    noise = np.sqrt(power * residual.size / max(count, 1.0))
    lost = space @ directions[noise > UNKNOWN * reached].T  # (parameters, directions)
    if not lost.size:
        return []
    share = np.sqrt(np.sum(lost**2, axis=1))
    most = [i for i in np.argsort(-share, kind="stable")[:MOST] if share[i] >= PART * share.max()]
    named = ", ".join(names[i] for i in sorted(most))
    how_many = f"{lost.shape[1]} of {space.shape[1]} directions of the model's parameters, mostly in {named}"
    return [f"these recordings do not excite {how_many}: another motion would be needed to tell them"]


def _random_columns(bench: Workbench, p: Array, names: Sequence[str]) -> Array:
    """(STATES, n, k) at random states; the same ones every time."""
    rng = np.random.default_rng(0)
    n = bench.effort.shape[1]
    states = [rng.uniform(-top, top, (STATES, n)) for top in (np.pi, SPEED, ACCELERATION)]
    jacobian: Array = bench.kernel.rows("inverse_dynamics_parameter_jacobian_p", *states, p)
    return jacobian[:, :, [bench.index[name] for name in names]]
