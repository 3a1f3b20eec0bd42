"""The search over a family's unit cube: a spread pool, then differential evolution, deterministic by its seed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import optimize
from scipy.stats import qmc
from threadpoolctl import threadpool_limits

from symdyn.numeric.experiment.explanations import Explained
from symdyn.numeric.experiment.motions import Family, Motion

Array = NDArray[np.float64]

POOL = 64  # points spread over the cube: what any motion does, and where the search starts
LEAST_MEMBERS = 16  # of the population
SAMPLES, FEWER_SAMPLES = 500, 250  # of a motion while it is searched; of arms with more than two joints
SHRINK, SHRINKINGS = 0.8, 15  # where efforts exceed their limits


def pool(family: Family, seed: int) -> Array:
    """(POOL, size) points of low discrepancy (Sobol)."""
    return np.asarray(qmc.Sobol(family.size, rng=np.random.default_rng(seed)).random(POOL))


def members(family: Family) -> int:
    """Size of the population."""
    return max(LEAST_MEMBERS, min(POOL, family.size))


def samples(family: Family) -> int:
    return SAMPLES if len(family.limits.joints) <= 2 else FEWER_SAMPLES


def maximised(objective: Callable[[Array], float], population: Array, evaluations: int, seed: int) -> Array:
    """The best point found by differential evolution (Storn and Price 1997), from a population (members, size)."""
    size = population.shape[1]

    def loss(point: Array) -> float:
        return -objective(point)

    with threadpool_limits(1):  # the matrices are tall and narrow: threads would only wait for each other
        found = optimize.differential_evolution(
            loss,
            optimize.Bounds(np.zeros(size), np.ones(size)),
            init=population,
            maxiter=max(1, evaluations // len(population) - 1),
            rng=np.random.default_rng(seed),
            polish=False,
            tol=1e-4,
        )
    return np.asarray(found.x)


def feasible(family: Family, point: Array, models: tuple[Explained, ...], count: int = 0) -> Motion | None:
    """The point's motion, made smaller until no model needs more effort than there is; None where rest is too much.

    It has ``count`` samples; 0: as many as are searched on.
    """
    most = np.array([joint.effort for joint in family.limits.joints])
    for k in range(SHRINKINGS):
        motion = family.motion(point, count or samples(family), SHRINK**k)
        if not np.isfinite(most).any() or all(np.all(np.abs(model.effort(motion)) <= most) for model in models):
            return motion
    return None
