"""D-optimal design: the motion that tells one model's parameters best (Swevers et al. 1997)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, Problem
from symdyn.numeric.decomposition import pseudo_inverse
from symdyn.numeric.experiment.design import EVALUATIONS
from symdyn.numeric.experiment.explanations import Explained
from symdyn.numeric.experiment.limits import Limits
from symdyn.numeric.experiment.motions import Family, Motion
from symdyn.numeric.experiment.searching import feasible, maximised, members, pool, samples
from symdyn.numeric.experiment.separation import Noise
from symdyn.numeric.regression import RANK_TOLERANCE

Array = NDArray[np.float64]

FLOOR = 1e-30  # of an information in units of the parameters squared: a direction that a motion does not tell at all
HIDDEN = 1e-3  # part of a unit direction that must lie in what no motion tells, for a parameter to be lost in it


@dataclass(frozen=True, slots=True, eq=False)
class Identifying:
    """``standard_errors`` expected of each parameter, None where no motion tells it by itself.

    ``gain`` is by how much all that can be told is told better than on the median motion: the geometric mean of
    the ratio of standard errors.
    """

    point: Array
    motion: Motion
    standard_errors: dict[str, float | None]
    gain: float


def identifying(
    model: Explained,
    limits: Limits,
    noise: Noise,
    duration: float,
    *,
    seed: int = 0,
    evaluations: int = EVALUATIONS,
    progress: Callable[[str], None] = lambda _: None,
) -> Identifying:
    """The motion that makes the determinant of the information largest, in the directions that any motion tells.

    Raises InputError (SD333) where even rest needs more effort than the limits allow, or nothing can be fitted.
    """
    family = Family(limits, duration)
    points = pool(family, seed)
    progress("finding what motions can tell at all")
    size = np.abs(model.p[[model.kernel.parameters.index(name) for name in model.names]])
    size = np.where(size > 0, size, max(float(size.max(initial=0.0)), 1.0))
    grams = [g for g in (_information(model, family, point, noise, size) for point in points) if g is not None]
    if not grams or not model.names:
        raise InputError(Problem("SD333", "every motion needs more effort than the limits allow, or nothing is fitted"))
    power, vectors = np.linalg.eigh(np.mean(grams, axis=0))
    told = power > RANK_TOLERANCE**2 * max(float(power.max()), FLOOR)
    basis, lost = vectors[:, told], vectors[:, ~told]

    def objective(point: Array) -> float:
        gram = _information(model, family, point, noise, size)
        return -np.inf if gram is None else _volume(gram, basis)

    volumes = np.array([objective(point) for point in points])
    progress("searching the motion")
    best = maximised(
        lambda point: max(objective(point), -1e9), points[np.argsort(-volumes)][: members(family)], evaluations, seed
    )
    motion, gram = feasible(family, best, (model,), 2 * samples(family)), _information(model, family, best, noise, size)
    assert motion is not None  # the best is no worse than the pool's best
    assert gram is not None
    spread = basis @ pseudo_inverse(basis.T @ gram @ basis) @ basis.T
    alone = np.abs(lost).max(axis=1, initial=0.0) <= HIDDEN
    errors = np.sqrt(np.diag(spread)) * size
    gain = float(
        np.exp(0.5 * (_volume(gram, basis) - np.median(volumes[np.isfinite(volumes)])) / max(int(told.sum()), 1))
    )
    named = {name: float(e) if a else None for name, e, a in zip(model.names, errors, alone, strict=True)}
    return Identifying(best, motion, named, gain)


def _information(model: Explained, family: Family, point: Array, noise: Noise, size: Array) -> Array | None:
    """(k, k) Fisher information of the parameters in units of their sizes; None where the motion cannot be made."""
    motion = feasible(family, point, (model,))
    if motion is None:
        return None
    jacobian = model.kernel.rows("inverse_dynamics_parameter_jacobian_p", motion.q, motion.qd, motion.qdd, model.p)
    at = [model.kernel.parameters.index(name) for name in model.names]
    columns = (jacobian[:, :, at] * noise.weight[:, None] * size).reshape(-1, len(at))
    return np.asarray(columns.T @ columns * (family.duration * noise.rate / len(motion.time)))


def _volume(gram: Array, basis: Array) -> float:
    """log det of the information in the directions that can be told."""
    power = np.linalg.eigvalsh(basis.T @ gram @ basis)
    return float(np.sum(np.log(np.maximum(power, FLOOR))))
