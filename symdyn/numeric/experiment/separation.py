"""How far two explanations are apart on a motion: the expected log-likelihood that the wrong one loses, refitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.experiment.explanations import Explained, best_refit, linear_refit
from symdyn.numeric.experiment.motions import Motion
from symdyn.numeric.observation import Observation
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Noise:
    """Effort noise ``sigma`` (n,) of each joint, r.m.s., in samples that are independent at ``rate`` Hz.

    What a model leaves unexplained counts as noise: a motion must tell explanations apart in spite of it.
    """

    sigma: Array
    rate: float

    @property
    def weight(self) -> Array:
        return 1.0 / self.sigma

    def nats(self, weighted: Array, duration: float) -> float:
        """-log likelihood that a residual (N, n) in units of sigma costs over this time: half its power."""
        return float(0.5 * duration * self.rate * np.mean(np.sum(weighted**2, axis=1)))


def lost(truth: Explained, rival: Explained, motion: Motion, noise: Noise, at: Sequence[Array]) -> float:
    """Nats that the rival loses where ``truth`` holds, refitted, at the best of the parameter vectors ``at``.

    The refit is linear about each vector: exact but for shape parameters (an order), for which several are given.
    """
    bench = _imagined(truth, rival, motion)
    return min(noise.nats(linear_refit(rival, bench, p, noise.weight)[1], _span(motion)) for p in at)


def refitted(truth: Explained, rival: Explained, motion: Motion, noise: Noise) -> tuple[float, Array]:
    """(nats that the rival loses, its best parameters), shape parameters searched and bounds kept."""
    bench = _imagined(truth, rival, motion)
    p = best_refit(rival, bench, noise.weight)
    return noise.nats(bench.residual(p) * noise.weight, _span(motion)), p


def _imagined(truth: Explained, rival: Explained, motion: Motion) -> Workbench:
    """The rival, on the motion with the efforts that it would take if the other were true."""
    effort = truth.effort(motion)
    step = float(motion.time[1] - motion.time[0])
    whole = (slice(0, len(effort)),)
    still = np.zeros(motion.q.shape[1])
    seen = Observation(motion.time, motion.q, motion.qd, motion.qdd, effort, whole, step, 0.4 / step, motion.q, still)
    return Workbench(rival.kernel, seen, planned=True)


def _span(motion: Motion) -> float:
    return float(motion.time[-1] - motion.time[0])
