"""Candidate effects along one recording: their columns in the analysis band."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.probe import Probe
from symdyn.numeric.scan import WAVES, grid
from symdyn.numeric.workbench import Workbench
from symdyn.spec.effect_schema import Scan
from symdyn.spec.records import Motion

Array = NDArray[np.float64]

SLOPE_STEP = 1e-4  # of a shape value, for the derivative with respect to it


class Laws:
    """Columns of candidates at their joints; once made, they serve every later step."""

    def __init__(self, probes: Mapping[Motion, Probe], bench: Workbench, joints: Sequence[str]) -> None:
        self.probes, self.bench, self.joints = probes, bench, tuple(joints)
        self._ends: dict[str, list[tuple[float, float]]] = {}
        self._known: dict[tuple[str, str, tuple[float, ...]], Array] = {}

    def joint(self, candidate: Candidate) -> int:
        return self.joints.index(candidate.place.address)

    def columns(self, candidate: Candidate, shapes: Sequence[float]) -> Array:
        """(K, k) effort at the candidate's joint per unit of each linear parameter."""
        key = (candidate.effect, candidate.place.address, tuple(shapes))
        if key not in self._known:
            probe, joint = self.probes[candidate.place.motion], self.joint(candidate)
            forces = []
            for unit in np.eye(len(candidate.linear)):
                values = candidate.values(unit.tolist(), shapes)
                forces.append(probe.force(candidate.effect, values, self.bench.observation, joint))
            self._known[key] = self.bench.bring(np.stack(forces, axis=1))
        return self._known[key]

    def ends(self, candidate: Candidate) -> list[tuple[float, float]]:
        """Between which a fit may move each shape parameter: those of its scan, and of an order, one whole wave."""
        if candidate.label not in self._ends:
            axes = zip(*grid(candidate, self.joint(candidate), self.bench), strict=True)
            room = [WAVES if schema.scan is Scan.ANGLE_ORDER else 1.0 for schema in candidate.shapes]
            self._ends[candidate.label] = [(min(axis) / more, max(axis)) for axis, more in zip(axes, room, strict=True)]
        return self._ends[candidate.label]

    def slopes(self, candidate: Candidate, coefficients: Sequence[float], shapes: Sequence[float]) -> Array:
        """(K, s) derivative of the effort with respect to each shape value."""
        found = []
        for i, value in enumerate(shapes):
            step = SLOPE_STEP * abs(value)
            high, low = list(shapes), list(shapes)
            high[i], low[i] = value + step, value - step
            change = (self.columns(candidate, high) - self.columns(candidate, low)) / (2.0 * step)
            found.append(change @ np.asarray(coefficients))
        return np.stack(found, axis=1) if found else np.zeros((len(self.bench.effort), 0))

    def spread(self, candidate: Candidate, columns: Array) -> Array:
        """(K, k) at the candidate's joint to (K, n, k) at all."""
        full = np.zeros((*self.bench.effort.shape, columns.shape[1]))
        full[:, self.joint(candidate)] = columns
        return full
