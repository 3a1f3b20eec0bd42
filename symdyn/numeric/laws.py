"""Candidate effects along one recording: their columns in the analysis band."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.carried import Friction
from symdyn.numeric.kept import Kept
from symdyn.numeric.observation import smoothed
from symdyn.numeric.probe import Key, Probe, key_of
from symdyn.numeric.scan import axes, nudge, room
from symdyn.numeric.workbench import Workbench
from symdyn.physics import load_dependent
from symdyn.spec.effect_schema import ParameterSchema, Scan

Array = NDArray[np.float64]
END = 1.05  # of the first value that is scanned: a fit left the number there


class Laws:
    """Columns of candidates at their joints; once made, they serve every later step.

    Those of friction that depends on the load depend on what the model makes of that: on its parameters ``p``. Above
    ``motion`` (Hz) the recorded motion is noise. ``known``: of each joint, the forces of the others in this band that
    were asked for before; they depend on nothing but its motion.
    """

    def __init__(
        self,
        probes: Mapping[Key, Probe],
        bench: Workbench,
        joints: Sequence[str],
        frictions: Sequence[Friction],
        motion: float,
        known: Sequence[Kept] | None = None,
    ) -> None:
        self.probes, self.bench, self.joints, self.frictions = probes, bench, tuple(joints), tuple(frictions)
        self.motion = motion
        self._axes: dict[str, list[list[float]]] = {}
        self._known: Sequence[Kept] = [Kept() for _ in self.joints] if known is None else known
        self._under: dict[str, tuple[bytes, Array]] = {}  # of a candidate, the last, and under which parameters

    def joint(self, candidate: Candidate) -> int:
        return self.joints.index(candidate.place.address)

    def columns(self, candidate: Candidate, shapes: Sequence[float], p: Array) -> Array:
        """(K, k) effort at the candidate's joint per unit of each linear parameter."""
        if candidate.effect in load_dependent():
            of, known = self._under.get(candidate.law, (b"", np.zeros(0)))
            if of != p.tobytes():
                joint = self.joint(candidate)
                known = self._forces(candidate, shapes, self.load(joint, p)) * self.bench.counted[:, joint, None]
                self._under[candidate.law] = p.tobytes(), known
            return known
        joint = self.joint(candidate)
        forces = self._known[joint].of((candidate.law, tuple(shapes)), lambda: self._forces(candidate, shapes))
        return np.asarray(forces * self.bench.counted[:, joint, None])

    def starts(self, candidate: Candidate, shapes: Sequence[float]) -> Array:
        """(K, m) effort at the candidate's joint because of how its states began; m = 0 for most."""
        joint = self.joint(candidate)
        forces = self._known[joint].of(
            (f"{candidate.law}, begun", tuple(shapes)), lambda: self._begun(candidate, shapes)
        )
        return np.asarray(forces * self.bench.counted[:, joint, None])

    def _begun(self, candidate: Candidate, shapes: Sequence[float]) -> Array:
        """(K, m) in the analysis band."""
        values = candidate.values([1.0] * len(candidate.linear), shapes)
        return self.bench.bring(self.probes[key_of(candidate)].starts(candidate.effect, values, self.bench.observation))

    def load(self, joint: int, p: Array) -> Array:
        """(N,) effort that passes through a joint: what the model needs there, less its friction.

        Accelerations carry the noise of positions, quicker than the motion. What is linear in them loses it in the
        analysis band; the size of a load would turn it into more load, in the course of what is left.
        """
        seen = self.bench.observation
        load = (seen.tau - self.bench.raw_residual(p))[:, joint]
        for friction in self.frictions:
            if self.joint(friction.law) == joint:
                values = friction.at(p, self.bench.index)
                load = load - self.probes[key_of(friction.law)].force(friction.law.effect, values, seen, joint)
        return smoothed(load, seen.segments, seen.rate, self.motion)

    def _forces(self, candidate: Candidate, shapes: Sequence[float], load: Array | None = None) -> Array:
        """(K, k) in the analysis band."""
        probe, joint = self.probes[key_of(candidate)], self.joint(candidate)
        forces = []
        for unit in np.eye(len(candidate.linear)):
            values = candidate.values(unit.tolist(), shapes)
            forces.append(probe.force(candidate.effect, values, self.bench.observation, joint, load))
        return self.bench.bring(np.stack(forces, axis=1))

    def room(self, candidate: Candidate, scanned: Sequence[float]) -> list[tuple[float, float]]:
        """Between which a fit may move each shape parameter."""
        return [room(*of) for of in zip(candidate.shapes, self._scanned(candidate), scanned, strict=True)]

    def _scanned(self, candidate: Candidate) -> list[list[float]]:
        if candidate.law not in self._axes:
            self._axes[candidate.law] = axes(candidate, self.joint(candidate), self.bench)
        return self._axes[candidate.law]

    def at_end(self, candidate: Candidate, shapes: Sequence[float]) -> tuple[ParameterSchema, ...]:
        """What a fit left at an end: where a curve turns over (it is a jump there, or a line), a filter's damping."""
        found = []
        for schema, value, axis in zip(candidate.shapes, shapes, self._scanned(candidate), strict=True):
            if schema.scan is Scan.TURNOVER and not END * axis[0] < value < axis[-1] / END:
                found.append(schema)
            if schema.scan is Scan.DAMPING and value >= axis[-1] / END:
                found.append(schema)
        return tuple(found)

    def slopes(self, candidate: Candidate, coefficients: Sequence[float], shapes: Sequence[float], p: Array) -> Array:
        """(K, s) derivative of the effort with respect to each shape value."""
        found = []
        for i, value in enumerate(shapes):
            step = nudge(candidate.shapes[i], value)
            high, low = list(shapes), list(shapes)
            high[i], low[i] = value + step, value - step
            change = (self.columns(candidate, high, p) - self.columns(candidate, low, p)) / (2.0 * step)
            found.append(change @ np.asarray(coefficients))
        return np.stack(found, axis=1) if found else np.zeros((len(self.bench.effort), 0))

    def spread(self, candidate: Candidate, columns: Array) -> Array:
        """(K, k) at the candidate's joint to (K, n, k) at all."""
        full = np.zeros((*self.bench.effort.shape, columns.shape[1]))
        full[:, self.joint(candidate)] = columns
        return full
