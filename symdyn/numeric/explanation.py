"""One explanation of a recording: the model with some effects added, fitted, and how it does held out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from symdyn.numeric.candidates import Candidate, bounds, candidate_bounds, fitted_parameters
from symdyn.numeric.findings import Errors, Estimate
from symdyn.numeric.fitting import Fit, fit, joint_weight, relative_error
from symdyn.numeric.regression import encompassing
from symdyn.numeric.workbench import Workbench
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

LEVEL = 0.01  # significance of a gain
CERTAIN = float(stats.norm.isf(LEVEL / 2.0))  # standard errors from null
EARNS = 0.03  # an effect that takes less than this part off the held-out error is not worth a line in a model

Found = tuple[tuple[Candidate, float | None], ...]  # candidates with the scanned value of their shape parameter


@dataclass(frozen=True, slots=True, eq=False)
class Explanation:
    """``found`` on top of the model as given, with all parameters fitted together on training data."""

    found: Found
    fit: Fit
    weight: Array  # (n,) of each joint
    training: Array  # (K, n) residuals in the analysis band
    heldout: Array

    @property
    def effects(self) -> frozenset[tuple[str, str]]:
        return frozenset((c.effect, c.place.address) for c, _ in self.found)


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """What does not change during a diagnosis: the robot, and its kernel on both recordings."""

    robot: Robot
    bench: Workbench  # training
    judge: Workbench  # held out

    @property
    def joints(self) -> list[str]:
        return [joint.name for joint in self.robot.joints]

    def explain(self, found: Found = ()) -> Explanation:
        """Fit the model with the effects found. Raises NumericalError if the fit does not settle."""
        bench = self.bench
        p, limits = bench.kernel.values, bounds(self.robot)
        names = own_parameters(self.robot, bench)
        for candidate, shape in found:
            limits |= candidate_bounds(candidate, shape)
            names += [candidate.parameter(schema) for schema in candidate.linear]
            if candidate.shape is not None and shape is not None:
                p[bench.index[candidate.parameter(candidate.shape)]] = shape
                names.append(candidate.parameter(candidate.shape))
        weight = np.ones(bench.effort.shape[1])
        for _ in range(2):  # the weights follow the size of each joint's residual
            done = fit(bench, p, names, weight, limits)
            weight = joint_weight(bench.residual(done.p), bench.effort)
        return Explanation(found, done, weight, bench.residual(done.p), self.judge.residual(done.p))

    def errors(self, of: Explanation) -> Errors:
        """Relative errors of the effort."""
        return Errors(relative_error(of.training, self.bench.effort), relative_error(of.heldout, self.judge.effort))

    def earns(self, before: Explanation, after: Explanation) -> bool:
        """Held-out error falls by more than chance, over all, and at some joint by enough to matter."""
        gain, p_value = heldout_gain(before, after)
        falls = gain > 0 and self.errors(after).heldout < self.errors(before).heldout
        old, new = (joint_errors(e.heldout, self.judge) for e in (before, after))
        return falls and p_value < LEVEL and bool(np.any(new <= (1.0 - EARNS) * old))

    def parameters(self, candidate: Candidate, of: Explanation) -> dict[str, Estimate]:
        """The candidate's parameters as fitted, by their names in the effect's declaration."""
        schemas = (*candidate.linear, *((candidate.shape,) if candidate.shape is not None else ()))
        return {
            schema.name: Estimate(
                float(of.fit.p[self.bench.index[candidate.parameter(schema)]]),
                of.fit.standard_error(candidate.parameter(schema)),
                candidate.unit(schema),
            )
            for schema in schemas
        }

    def certain(self, candidate: Candidate, of: Explanation) -> bool:
        """Whether any of its parameters can be told from the value at which it vanishes."""
        estimates = self.parameters(candidate, of)
        return any(
            e.se is None or abs(e.value - (schema.null or 0.0)) > CERTAIN * e.se
            for schema, e in ((s, estimates[s.name]) for s in candidate.linear)
        )

    def model_parameters(self, of: Explanation) -> dict[str, Estimate]:
        """The model's own parameters as fitted."""
        units = self.bench.kernel.parameter_units
        own = {p.name for p in self.robot.parameters}
        return {
            name: Estimate(
                float(of.fit.p[self.bench.index[name]]), of.fit.standard_error(name), units[self.bench.index[name]]
            )
            for name in of.fit.names
            if name in own
        }


def own_parameters(robot: Robot, bench: Workbench) -> list[str]:
    """The model's own parameters that inverse dynamics depends on in this recording."""
    values = bench.kernel.values
    return [name for name in fitted_parameters(robot) if np.any(bench.columns(values, [name]))]


def heldout_gain(before: Explanation, after: Explanation) -> tuple[float, float]:
    """(fall of the squared held-out error, p-value of none)."""
    return encompassing(before.heldout * before.weight, after.heldout * before.weight)


def joint_errors(residual: Array, bench: Workbench) -> Array:
    """(n,) relative error per joint."""
    return np.array([relative_error(residual[:, [j]], bench.effort[:, [j]]) for j in range(residual.shape[1])])


def ready(proposed: Sequence[Candidate], robot: Robot, effects: frozenset[tuple[str, str]]) -> list[Candidate]:
    """Candidates not yet in the model whose basis (what they correct) is in it."""
    present = effects | {(e.type, e.at) for e in robot.effects}
    return [
        c
        for c in proposed
        if (c.effect, c.place.address) not in present
        and (c.builds_on is None or (c.builds_on, c.place.address) in present)
    ]
