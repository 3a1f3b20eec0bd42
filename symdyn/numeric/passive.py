"""Joints that nothing drives, beside others that are: their equations have no effort to give them a size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel
from symdyn.numeric.observation import Observation

Array = NDArray[np.float64]

PLACES = 64  # of the motion, over which an inertia is averaged
LEAST = 1e-9  # of the inertia as given


class Passive:
    """Inertia about each passive joint, by which its residual becomes an acceleration.

    Where no effort is measured, what a residual is made of is the noise of accelerations times the inertia: the
    smaller the machine, the smaller the residual. Divided by the inertia it no longer is. Total least squares of a
    homogeneous equation, in other words, with the coefficient of the acceleration for its scale.
    """

    def __init__(self, kernel: Kernel, observation: Observation, index: Mapping[str, int]) -> None:
        driven = np.any(observation.tau, axis=0)
        self.joints: list[int] = np.flatnonzero(~driven & observation.tested).tolist() if np.any(driven) else []
        self._kernel, self._index, self._n = kernel, index, len(driven)
        at = np.unique(np.linspace(0, len(observation.q) - 1, PLACES).astype(int))
        self._q = np.ascontiguousarray(observation.q[at])
        self._least = LEAST * np.abs(self._mean(kernel.values))

    def inertia(self, p: Array) -> Array:
        """(n,) at the parameters ``p``; 1 where a joint is driven."""
        found = np.ones(self._n)
        found[self.joints] = np.maximum(self._mean(p), self._least)
        return found

    def slopes(self, p: Array, names: Sequence[str]) -> Array:
        """(n, k) derivatives of its logarithm with respect to parameters."""
        found = np.zeros((self._n, len(names)))
        where = [self._index[name] for name in names]
        for joint, inertia in zip(self.joints, self.inertia(p)[self.joints], strict=True):
            ends = [
                self._kernel.rows("inverse_dynamics_parameter_jacobian_p", *x, p)[:, joint] for x in self._moves(joint)
            ]
            found[joint] = np.mean(ends[0] - ends[1], axis=0)[where] / inertia
        return found

    def _mean(self, p: Array) -> Array:
        """(m,) of the passive joints."""
        if not self.joints:
            return np.zeros(0)
        mass = self._kernel.rows("mass_matrix_p", self._q, p)
        return np.asarray(np.mean(mass[:, self.joints, self.joints], axis=0))

    def _moves(self, joint: int) -> tuple[tuple[Array, Array, Array], ...]:
        """From rest with unit acceleration of a joint, and without."""
        rest = np.zeros_like(self._q)
        unit = rest.copy()
        unit[:, joint] = 1.0
        return (self._q, rest, unit), (self._q, rest, rest)
