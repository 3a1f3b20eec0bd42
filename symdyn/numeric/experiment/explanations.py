"""One of the explanations that an experiment weighs: a robot, its kernel, what a fit may move, and such a fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, NumericalError, Problem
from symdyn.compiler import compile_robot
from symdyn.emit.kernel import Kernel
from symdyn.numeric.candidates import Candidate, bounds, fitted_parameters
from symdyn.numeric.experiment.motions import Motion
from symdyn.numeric.fitting import fit
from symdyn.numeric.mechanics import mechanics, soft_rotors
from symdyn.numeric.regression import solve_linear
from symdyn.numeric.scan import grid, screened
from symdyn.numeric.workbench import Workbench
from symdyn.physics import catalogue
from symdyn.spec.effect_schema import Scan
from symdyn.spec.places import places
from symdyn.spec.records import EffectSpec, PlaceKind, Robot

Array = NDArray[np.float64]

NEAR = 2.0  # factor within which a shape parameter stays, as in a diagnosis
ABOUT = 9  # values of it that are tried about its own


@dataclass(frozen=True, slots=True)
class Shape:
    """A parameter that no linear fit finds (an angle order, a characteristic speed), and where it acts."""

    parameter: str
    candidate: Candidate
    joint: int
    relative_to: str | None = None  # the parameter that its scan is relative to


@dataclass(frozen=True, slots=True, eq=False)
class Explained:
    """A robot with its numbers ``p``; ``names`` are the parameters that a fit to a recording may move."""

    robot: Robot
    kernel: Kernel
    p: Array
    names: tuple[str, ...]
    shapes: tuple[Shape, ...]
    limits: Mapping[str, tuple[float, float]]

    def effort(self, motion: Motion) -> Array:
        """(N, n) that the motion takes."""
        return self.kernel.rows("inverse_dynamics_p", motion.q, motion.qd, motion.qdd, self.p)

    def with_values(self, p: Array) -> Explained:
        """The same structure with other numbers, in its robot too."""
        at = {name: float(value) for name, value in zip(self.kernel.parameters, p, strict=True)}
        parameters = tuple(replace(q, value=at.get(q.name, q.value)) for q in self.robot.parameters)
        return replace(self, robot=replace(self.robot, parameters=parameters), p=p)


def explained(robot: Robot) -> Explained:
    """Compile a robot for the design of an experiment.

    Raises InputError (SD332) where coordinates or states would have to be known that no joint shows, or a
    parameter has no number.
    """
    kernel = compile_robot(mechanics(robot)).kernel()
    hidden = [*soft_rotors(robot), *kernel.states[2 * len(kernel.coordinates) :]]
    if hidden:
        message = f"'{robot.name}' has what the motion of its joints does not tell: {', '.join(hidden)}"
        hint = "experiments are designed for rigid transmissions: fix the rotors to their joint (fixed_to_joint = true)"
        raise InputError(Problem("SD332", message, robot.where, hint))
    free = [n for n, v in zip(kernel.parameters, kernel.values, strict=True) if not np.isfinite(v)]
    if free:
        raise InputError(
            Problem("SD332", f"'{robot.name}' has parameters without a number: {', '.join(free)}", robot.where)
        )
    names = tuple(n for n in fitted_parameters(robot) if n in kernel.parameters)
    return Explained(robot, kernel, kernel.values, names, _shapes(robot), bounds(robot))


def linear_refit(rival: Explained, bench: Workbench, p: Array, weight: Array) -> tuple[Array, Array]:
    """(p refitted, what is left (K, n), weighted): linear about ``p``, without bounds, which gives it every chance."""
    target, columns = bench.residual(p) * weight, bench.columns(p, rival.names) * weight[:, None]
    step = solve_linear(columns, target) if rival.names else np.zeros(0)
    found = p.copy()
    found[[bench.index[name] for name in rival.names]] += step
    return found, target - columns @ step


def best_refit(rival: Explained, bench: Workbench, weight: Array) -> Array:
    """The rival's parameters that fit best: shape parameters searched, then all together within their bounds.

    A shape parameter is searched where a diagnosis of this motion would search it, and about its own value; it
    then stays within a factor ``NEAR`` of where it was found: a ripple without a whole wave is no ripple.
    Where no fit settles (a rival far from the data), the best linear one stands.
    """
    start = rival.p
    for shape in rival.shapes:
        index = bench.index[shape.parameter]
        left = linear_refit(rival, bench, start, weight)[1][:, shape.joint]
        searched = screened(shape.candidate, grid(shape.candidate, shape.joint, bench), left, shape.joint, bench)
        tried = [start]
        scale = start[bench.index[shape.relative_to]] if shape.relative_to else 1.0
        for value in (*(rival.p[index] * np.geomspace(1.0 / NEAR, NEAR, ABOUT)), *(scale * v for (v,) in searched)):
            p = start.copy()
            p[index] = value
            tried.append(linear_refit(rival, bench, p, weight)[0])
            tried[-1][index] = value
        start = min(tried, key=lambda p: _loss(bench, p, weight))
    found = []
    for begin in (rival.p, start):
        near = {
            s.parameter: (begin[bench.index[s.parameter]] / NEAR, begin[bench.index[s.parameter]] * NEAR)
            for s in rival.shapes
        }
        try:
            found.append(fit(bench, begin, rival.names, weight, {**rival.limits, **near}).p)
        except NumericalError:  # it does not settle from there
            continue
    return min(found, key=lambda p: _loss(bench, p, weight)) if found else start


def _loss(bench: Workbench, p: Array, weight: Array) -> float:
    return float(np.sum((bench.residual(p) * weight) ** 2))


def difference(first: Robot, second: Robot) -> tuple[tuple[EffectSpec, ...], tuple[EffectSpec, ...]]:
    """Effects that only the first, and that only the second has, by kind and place."""
    one, other = ({(e.type, e.at): e for e in robot.effects} for robot in (first, second))
    return tuple(e for k, e in one.items() if k not in other), tuple(e for k, e in other.items() if k not in one)


def _shapes(robot: Robot) -> tuple[Shape, ...]:
    where = {place.address: place for place in places(robot) if place.kind is PlaceKind.JOINT}
    order = [joint.name for joint in robot.joints]
    found = []
    for effect in robot.effects:
        declared = catalogue()[effect.type]
        schema = next((p for p in declared.parameters if p.scan not in (Scan.NONE, Scan.ASSUMED)), None)
        value = dict(effect.values).get(schema.name) if schema is not None else None
        if schema is None or value is None or effect.at not in where or len(value.factors) != 1:
            continue
        linear = tuple(p for p in declared.parameters if p.scan is Scan.NONE)
        candidate = Candidate(effect.type, declared.title, where[effect.at], linear, (schema,), declared.builds_on)
        base = dict(effect.values).get(schema.relative_to or "")
        relative = base.factors[0][0] if base is not None and len(base.factors) == 1 else None
        found.append(Shape(value.factors[0][0], candidate, order.index(effect.at), relative))
    return tuple(found)
