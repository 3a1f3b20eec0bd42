"""Residuals and regressors of one augmented robot on one recording, brought to the analysis band."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel
from symdyn.numeric.band import Band
from symdyn.numeric.observation import Observation

Array = NDArray[np.float64]


class Workbench:
    """Evaluates the kernel on a recording; parameter vectors are those of the augmented robot."""

    def __init__(self, kernel: Kernel, observation: Observation, band: Band | None = None) -> None:
        self.kernel, self.observation, self.band = kernel, observation, band
        self.index = {name: i for i, name in enumerate(kernel.parameters)}
        o = observation
        self._motion = tuple(np.ascontiguousarray(a) for a in (o.q, o.qd, o.qdd))
        self.effort = self.bring(o.tau)
        self._effects: dict[tuple[tuple[str, ...], tuple[str, float] | None], Array] = {}

    def raw_residual(self, p: Array) -> Array:
        """(N, n) measured effort less inverse dynamics, over the full band."""
        required: Array = self.kernel.inverse_dynamics_p_batch(*self._motion, p)
        return self.observation.tau - required

    def residual(self, p: Array) -> Array:
        """(K, n) the same in the analysis band."""
        return self.bring(self.raw_residual(p))

    def columns(self, p: Array, names: Sequence[str]) -> Array:
        """(K, n, k) d inverse dynamics / d parameter, in the analysis band."""
        jacobian = self.kernel.inverse_dynamics_parameter_jacobian_p_batch(*self._motion, p)
        return self.bring(np.ascontiguousarray(jacobian[:, :, [self.index[name] for name in names]]))

    def effect_columns(self, names: Sequence[str], shape: tuple[str, float] | None) -> Array:
        """(K, n, k) the columns of an effect's linear parameters, its ``shape`` parameter set to a value.

        An effect is linear in them and knows no other parameter, so that differences of two
        evaluations are exact, and columns once made serve every later step.
        """
        key = (tuple(names), shape)
        if key not in self._effects:
            p = self.kernel.values
            if shape is not None:
                p[self.index[shape[0]]] = shape[1]
            base = self.kernel.inverse_dynamics_p_batch(*self._motion, p)
            columns = []
            for name in names:
                unit = p.copy()
                unit[self.index[name]] += 1.0
                columns.append(self.bring(self.kernel.inverse_dynamics_p_batch(*self._motion, unit) - base))
            self._effects[key] = np.stack(columns, axis=2)
        return self._effects[key]

    def bring(self, values: Array) -> Array:
        """(N, ...) to (K, ...): into the analysis band, if there is one."""
        return values if self.band is None else self.band.bring(values, self.observation)

    @property
    def samples_per_period(self) -> float:
        """Samples per period of the band's edge."""
        rate = self.observation.rate
        return 2.0 if self.band is None else rate / (self.band.stride * self.band.cutoff)
