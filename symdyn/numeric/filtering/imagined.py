"""A recording that was never made: what a machine's channels would show, and how far another explanation is off."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.likelihood import MLFit, fit
from symdyn.numeric.filtering.model import Model
from symdyn.numeric.filtering.score import Left
from symdyn.numeric.filtering.signals import Signals

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Explaining:
    """One explanation of a machine, as it was fitted to what was recorded."""

    model: Model
    candidate: Candidate
    fit: MLFit

    def bench(self, signals: Signals) -> FilterBench:
        return self.model.bench(signals, self.fit.bench.noise, self.fit.bench.between)

    def shown(self, u: Array, noise: Array | None = None) -> Signals:
        """What the channels would show under the inputs ``u`` (N, nu), with so much ``noise`` (N, m) of the sensors.

        The machine starts where the recording began, at rest.
        """
        trained, kernel = self.model.training, self.model.kernel
        step, n = float(np.nanmedian(trained.steps)), len(kernel.coordinates)
        start = self.fit.bench.filtered(self.fit.p).states[0, : len(kernel.states)].copy()
        start[n : 2 * n] = 0.0
        steps = np.full(len(u), step)
        steps[-1] = np.nan
        silent = np.zeros((len(u), trained.y.shape[1]))
        time = np.arange(len(u), dtype=np.float64) * step
        asked = replace(trained, time=time, u=u, y=silent, steps=steps, known=None)
        y = self.bench(asked).simulated(self.fit.p, np.ascontiguousarray(start), 0, len(u))
        return replace(asked, y=y if noise is None else y + noise)

    def travelled(self, signals: Signals) -> tuple[Array, Array]:
        """(N, n) positions and speeds of all coordinates, by its own filter."""
        n = len(self.model.kernel.coordinates)
        states = self.bench(signals).filtered(self.fit.p).states
        return states[:, :n], states[:, n : 2 * n]

    def lost(self, signals: Signals) -> float:
        """Nats that it is off by, its parameters moved as far as that helps, to first order."""
        left = Left.of(self.bench(signals), self.fit.p, self.fit.names)
        return 0.5 * left.power if np.isfinite(left.power) else 0.0

    def refitted(self, signals: Signals) -> float:
        """-log L of those signals, all fitted anew, the noise too."""
        return fit(self.bench(signals), self.fit.p, self.fit.beliefs).loss
