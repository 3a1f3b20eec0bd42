"""One explanation of a recording: the model with some effects added, fitted, and how it does held out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from symdyn.numeric.candidates import Candidate, bounded, bounds, candidate_bounds, fitted_parameters
from symdyn.numeric.decomposition import pseudo_inverse
from symdyn.numeric.findings import Errors, Estimate
from symdyn.numeric.fitting import Fit, eased, joint_weight, minimise, relative_error
from symdyn.numeric.laws import Laws
from symdyn.numeric.observation import low_pass, motion_cutoff
from symdyn.numeric.regression import fit_linear, likelier, solve_linear, times, without
from symdyn.numeric.search import EARNS
from symdyn.numeric.sizes import sizes
from symdyn.numeric.verdict import NEGLIGIBLE
from symdyn.numeric.workbench import Workbench
from symdyn.physics import catalogue, load_dependent
from symdyn.spec.effect_schema import ParameterSchema, Scan
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

LEVEL = 0.01  # significance of a gain
CERTAIN = float(stats.norm.isf(LEVEL / 2.0))  # standard errors from null

SPREAD = 1.0  # a model's parameters are off by up to so much of their values, unless a recording tells otherwise
SHAPE_STEPS = 12  # Gauss-Newton steps of the shape parameters
TURNS = 4  # of a fit with friction by load, in each of which the load follows the last: a turn leaves a tenth
STEPS = 5  # of a fit of all else, between two of those
SETTLED = 1e-5  # relative fall of the loss below which they have settled

CARRIES = 0.01  # of the inertia that swings, that what carries it has at least

SCALES = frozenset({Scan.SPEED, Scan.TURNOVER, Scan.DISPLACEMENT, Scan.STEEPNESS, Scan.ANGLE_ORDER, Scan.FREQUENCY})
SPECK = 1e-6  # where a parameter that is none begins, to be one (gravity, in m/s^2)

Found = tuple[tuple[Candidate, tuple[float, ...]], ...]  # candidates with the scanned values of their shape parameters


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """Values of one found effect: of its linear parameters, and of its shapes."""

    coefficients: tuple[float, ...]
    shapes: tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Revised:
    """Something that the model or its sensors were told wrong, set right; ``names``: own parameters that do so."""

    effect: str
    title: str
    place: str
    values: Mapping[str, Estimate] = field(default_factory=dict)  # of an effect to be written
    names: Mapping[str, str] = field(default_factory=dict)  # by what a finding calls them


@dataclass(frozen=True, slots=True, eq=False)
class Explanation:
    """``found`` on top of the model as given, with all parameters fitted together on training data."""

    found: Found
    fit: Fit  # names: the model's own, then linear and shape parameters of each effect found
    fitted: tuple[Fitted, ...]  # of each effect found
    weight: Array  # (n,) of each joint
    design: Array  # (K, n, k) columns of all that was fitted, training
    training: Array  # (K, n) residuals in the analysis band
    heldout: Array

    @property
    def effects(self) -> frozenset[tuple[str, str]]:
        return frozenset((c.effect, c.place.address) for c, _ in self.found)


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """What does not change during a diagnosis: the robot, and what was seen of it, in one analysis band."""

    robot: Robot
    laws: Laws  # training
    judged: Laws  # held out
    own: tuple[str, ...]  # the model's own parameters that a fit moves
    revised: tuple[Revised, ...] = ()  # what was found about the sensors and the surroundings
    spread: float = SPREAD  # standard deviation that their values as given are thought to have, as a share of them

    @property
    def bench(self) -> Workbench:
        return self.laws.bench

    @property
    def judge(self) -> Workbench:
        return self.judged.bench

    @property
    def joints(self) -> list[str]:
        return [joint.name for joint in self.robot.joints]

    @property
    def unknown(self) -> frozenset[str]:
        """Parameters that the model as given knew nothing of."""
        return frozenset(name for r in self.revised for name in r.names.values())

    def explain(self, found: Found = (), near: Explanation | None = None) -> Explanation:
        """Fit the model with the effects found, from the values of an explanation ``near`` it, if there is one.

        Raises NumericalError if the fit does not settle.
        """
        p, weight = self.bench.kernel.values, np.ones(self.bench.effort.shape[1])
        known: dict[str, Fitted] = {}
        if near is not None:
            p, weight = near.fit.p, near.weight
            known = {c.label: f for (c, _), f in zip(near.found, near.fitted, strict=True)}
        state = [known.get(c.label, Fitted((0.0,) * len(c.linear), shapes)) for c, shapes in found]
        for _ in range(2):  # the weights follow the size of each joint's residual
            p, state = self._settled(found, p, state, weight)
            weight = joint_weight(self._residual(self.laws, found, p, state), self.bench.reference)
        training, design = self._residual(self.laws, found, p, state), self._design(self.laws, found, p, state)
        last = fit_linear(design * weight[:, None], training * weight)
        names = [*self.own, *(c.parameter(s) for c, _ in found for s in (*c.linear, *c.shapes))]
        done = Fit(tuple(names), p, last)
        return Explanation(
            found, done, tuple(state), weight, design, training, self._residual(self.judged, found, p, state)
        )

    def residual(self, laws: Laws, of: Explanation) -> Array:
        """(K, n) of another recording, or the same in another band."""
        return self._residual(laws, of.found, of.fit.p, of.fitted)

    def design(self, laws: Laws, of: Explanation) -> Array:
        """(K, n, k) columns of all that was fitted, on another recording, or on the same in another band."""
        return self._design(laws, of.found, of.fit.p, of.fitted)

    def _settled(self, found: Found, p: Array, state: list[Fitted], weight: Array) -> tuple[Array, list[Fitted]]:
        """Shape parameters by Gauss-Newton around the fit of all others, of which a few steps do until they settle."""
        weighed = p
        p, state, loss = self._linear(found, p, state, weight, weighed)
        count = sum(len(c.shapes) for c, _ in found)
        for _ in range(SHAPE_STEPS if count else 0):
            design = self._design(self.laws, found, p, state)
            residual = self._residual(self.laws, found, p, state)
            step = self._step(found, state, design * weight[:, None], residual * weight)
            for scale in (1.0, 0.25, 0.0625):
                moved = [
                    Fitted(f.coefficients, self._moved(self.laws.room(c, scanned), f.shapes, scale * change))
                    for (c, scanned), f, change in zip(found, state, self._shape_part(found, step), strict=True)
                ]
                trial_p, trial, lower = self._linear(found, p, moved, weight, weighed, STEPS)
                if lower < loss:
                    break
            else:
                break
            fall, p, state, loss = loss - lower, trial_p, trial, lower
            if fall <= SETTLED * loss:
                break
        if count:
            p, state, _ = self._linear(found, p, state, weight, weighed)
        return p, state

    def _step(self, found: Found, state: Sequence[Fitted], design: Array, residual: Array) -> Array:
        """Of everything; a shape parameter that stands at the end of its room, and would go further, stays there."""
        free = np.ones(design.shape[2], dtype=bool)
        while True:
            step = np.zeros(len(free))
            step[free] = solve_linear(design[:, :, free], residual)
            at, ends = len(self.own), []
            for (candidate, scanned), f in zip(found, state, strict=True):
                at += len(candidate.linear)
                for (low, high), value in zip(self.laws.room(candidate, scanned), f.shapes, strict=True):
                    if (value <= low and step[at] < 0.0) or (value >= high and step[at] > 0.0):
                        ends.append(at)
                    at += 1
            if not ends:
                return step
            free[ends] = False

    @staticmethod
    def _moved(room: Sequence[tuple[float, float]], shapes: tuple[float, ...], step: Array) -> tuple[float, ...]:
        return tuple(
            float(np.clip(value + change, low, high))
            for (low, high), value, change in zip(room, shapes, step, strict=True)
        )

    def _shape_part(self, found: Found, step: Array) -> list[Array]:
        """Of a step of everything, in the order of the design, the shapes of each effect found."""
        at, parts = len(self.own), []
        for candidate, _ in found:
            at += len(candidate.linear)
            parts.append(step[at : at + len(candidate.shapes)])
            at += len(candidate.shapes)
        return parts

    def _linear(
        self, found: Found, p: Array, state: list[Fitted], weight: Array, weighed: Array, steps: int | None = None
    ) -> tuple[Array, list[Fitted], float]:
        """Everything but the shapes, fitted: also the loss that is left, with a weight for parameters ``weighed``."""
        limits, known = bounds(self.robot), sizes(self.robot)
        names = [c.parameter(s) for c, _ in found for s in c.linear]
        for candidate, _ in found:
            limits |= candidate_bounds(candidate)
        start = np.array([value for f in state for value in f.coefficients])
        begun = self._begun(self.laws, found, state)
        names += [f"begun_{i}" for i in range(begun.shape[2])]
        start = np.concatenate([start, np.zeros(begun.shape[2])])
        loaded = any(candidate.effect in load_dependent() for candidate, _ in found)
        for _ in range(TURNS if loaded else 1):
            added = np.concatenate([self._added(self.laws, found, state, p), begun], axis=2)
            p, start = minimise(
                self.bench,
                p,
                self.own,
                added,
                start,
                names,
                weight,
                limits,
                known,
                self.spread,
                self.unknown,
                weighed,
                steps,
            )
        done, at = [], 0
        for f in state:
            count = len(f.coefficients)
            done.append(Fitted(tuple(float(x) for x in start[at : at + count]), f.shapes))
            at += count
        weight = weight * (self.bench.passive.inertia(weighed) / self.bench.passive.inertia(p))
        return p, done, float(np.sum((self._residual(self.laws, found, p, done) * weight) ** 2))

    def _added(self, laws: Laws, found: Found, state: Sequence[Fitted], p: Array) -> Array:
        """(K, n, e) columns of the linear parameters of all effects found."""
        parts = [laws.spread(c, laws.columns(c, f.shapes, p)) for (c, _), f in zip(found, state, strict=True)]
        return np.concatenate([np.zeros((*laws.bench.effort.shape, 0)), *parts], axis=2)

    def _residual(self, laws: Laws, found: Found, p: Array, state: Sequence[Fitted]) -> Array:
        coefficients = np.array([value for f in state for value in f.coefficients])
        own = laws.bench.left(p, self.own)
        left = own - times(self._added(laws, found, state, p), coefficients)
        return without(left, self._begun(laws, found, state))

    @staticmethod
    def _begun(laws: Laws, found: Found, state: Sequence[Fitted]) -> Array:
        """(K, n, m) columns of how hidden states began, where that goes on for long."""
        parts = [np.zeros((*laws.bench.effort.shape, 0))]
        for (candidate, _), f in zip(found, state, strict=True):
            parts.append(laws.spread(candidate, laws.starts(candidate, f.shapes)))
        return np.concatenate(parts, axis=2)

    def _design(self, laws: Laws, found: Found, p: Array, state: Sequence[Fitted]) -> Array:
        """(K, n, k) columns of all that is fitted, in the order of the names of a fit."""
        own = laws.bench.moved(p, self.own)
        if laws.bench.passive.joints:
            own = own + eased(laws.bench, p, self.own, self._residual(laws, found, p, state))
        parts = [own]
        for (candidate, _), f in zip(found, state, strict=True):
            parts.append(laws.spread(candidate, laws.columns(candidate, f.shapes, p)))
            parts.append(laws.spread(candidate, laws.slopes(candidate, f.coefficients, f.shapes, p)))
        return without(np.concatenate(parts, axis=2), self._begun(laws, found, state))

    def errors(self, of: Explanation) -> Errors:
        """Relative errors of the effort."""
        return Errors(
            relative_error(of.training, self.bench.reference), relative_error(of.heldout, self.judge.reference)
        )

    def nothing_left(self, of: Explanation) -> bool:
        """Whether no effect could take off enough to be told."""
        seen = joint_errors(of.training, self.bench), joint_errors(of.heldout, self.judge)
        return bool(np.all(np.concatenate(seen) <= NEGLIGIBLE))

    def earns(self, before: Explanation, after: Explanation) -> bool:
        """Held-out error falls by more than chance, over all, and at some joint by enough to matter."""
        gain, p_value = heldout_gain(before, after)
        falls = gain > 0 and self.errors(after).heldout < self.errors(before).heldout
        old, new = (joint_errors(e.heldout, self.judge) for e in (before, after))
        takes = np.sqrt(np.maximum(old**2 - new**2, 0.0))
        return falls and p_value < LEVEL and bool(np.any((new <= (1.0 - EARNS) * old) & (takes > NEGLIGIBLE)))

    def confirms(self, candidate: Candidate, before: Explanation, after: Explanation) -> bool:
        """Whether a candidate that ``after`` has beside ``before`` earns its place.

        What swings must do so below the frequency at which the motion of its joint sinks into noise: beyond, it is a
        filter that lets less of the noise of accelerations through. And it swings on what has an inertia, too.
        """
        if any(schema.scan is Scan.FREQUENCY for schema in candidate.shapes):
            seen, joint = self.judge.observation, self.laws.joint(candidate)
            held = self.bench.kernel.mass_matrix_p(np.median(seen.q, axis=0), after.fit.p)[joint, joint]
            swinging = after.fitted[[c for c, _ in after.found].index(candidate)].coefficients[0]
            if self.bounded(candidate, after) or held < CARRIES * swinging:
                return False
            known = motion_cutoff(seen.measured[:, [joint]], seen.segments, seen.rate)
            rate = self.judge.samples_per_period * self.judge.edge
            before, after = (replace(each, heldout=low_pass(each.heldout, rate, known)) for each in (before, after))
        return self.earns(before, after)

    def parameters(self, candidate: Candidate, of: Explanation) -> dict[str, Estimate]:
        """The candidate's parameters as fitted, by their names in the effect's declaration."""
        fitted = next(f for (c, _), f in zip(of.found, of.fitted, strict=True) if c is candidate)
        values = candidate.values(fitted.coefficients, fitted.shapes)
        told = {s.name: of.fit.standard_error(candidate.parameter(s)) for s in (*candidate.linear, *candidate.shapes)}
        for schema, ratio in zip(candidate.shapes, fitted.shapes, strict=True):
            if schema.relative_to is not None:
                told[schema.name] = self._error_of_product(candidate, schema, ratio, values, of)
        return {
            schema.name: Estimate(values[schema.name], told.get(schema.name), candidate.unit(schema))
            for schema in (*candidate.linear, *candidate.shapes, *(schema for schema, _ in candidate.taken))
        }

    @staticmethod
    def _error_of_product(
        candidate: Candidate, schema: ParameterSchema, ratio: float, values: Mapping[str, float], of: Explanation
    ) -> float | None:
        """Standard error of a ratio times what it is relative to, by their joint covariance."""
        (base,) = (s for s in candidate.linear if s.name == schema.relative_to)
        at = [of.fit.names.index(candidate.parameter(s)) for s in (schema, base)]
        if not np.all(of.fit.last.identifiable[at]):
            return None
        scale = candidate.scale(schema, values)
        slope = np.array([scale, ratio if not schema.inversely else -ratio * scale**2])
        return float(np.sqrt(max(slope @ of.fit.last.covariance[np.ix_(at, at)] @ slope, 0.0)))

    def bounded(self, candidate: Candidate, of: Explanation) -> tuple[ParameterSchema, ...]:
        """Parameters of the candidate that would fit better beyond their bounds."""
        fitted = next(f for (c, _), f in zip(of.found, of.fitted, strict=True) if c is candidate)
        return (*bounded(candidate, fitted.coefficients), *self.laws.at_end(candidate, fitted.shapes))

    def certain(self, candidate: Candidate, of: Explanation) -> bool:
        """Whether any of its parameters can be told from the value at which it vanishes, its shape being given.

        A size and a shape that share their uncertainty (a spring and its lever) are certain together. But a scale (a
        speed, a distance) that may as well be twice as large, or nothing, is none.
        """
        at = {s.name: of.fit.names.index(candidate.parameter(s)) for s in (*candidate.linear, *candidate.shapes)}
        estimates, shapes = self.parameters(candidate, of), [at[s.name] for s in candidate.shapes]
        covariance = of.fit.last.covariance
        scales = (estimates[s.name] for s in candidate.shapes if s.scan in SCALES)
        if any(e.se is not None and e.se > abs(e.value) for e in scales):
            return False
        for schema in candidate.linear:
            i = at[schema.name]
            variance = float(covariance[i, i])
            if shapes:
                across = covariance[i, shapes]
                variance -= float(across @ pseudo_inverse(covariance[np.ix_(shapes, shapes)]) @ across)
            size = abs(estimates[schema.name].value - (schema.null or 0.0))
            if not of.fit.last.identifiable[i] or size > CERTAIN * np.sqrt(max(variance, 0.0)):
                return True
        return False

    def model_parameters(self, of: Explanation) -> dict[str, Estimate]:
        """The model's own parameters as fitted."""
        units = self.bench.kernel.parameter_units
        own = {p.name for p in self.robot.parameters}
        found = {}
        for name in (n for n in of.fit.names if n in own):
            value, se = float(of.fit.p[self.bench.index[name]]), of.fit.standard_error(name)
            if name in self.unknown and abs(value) <= 2.0 * SPECK:
                value = 0.0  # what no joint feels stays at its start
            found[name] = Estimate(value, se, units[self.bench.index[name]])
        return found


def own_parameters(robot: Robot, bench: Workbench) -> tuple[str, ...]:
    """The model's own parameters that inverse dynamics depends on in this recording.

    Without any effort nothing tells how heavy the machine is: masses and their centres are taken as given.
    """
    names = fitted_parameters(robot, scaled=bool(np.any(bench.effort)))
    if not names:
        return ()
    moving = np.any(bench.columns(bench.kernel.values, names), axis=(0, 1))
    return tuple(name for name, moves in zip(names, moving, strict=True) if moves)


def heldout_gain(before: Explanation, after: Explanation) -> tuple[float, float]:
    """(gain of the held-out log-likelihood per sample, doubled; p-value of none)."""
    return likelier(before.heldout * before.weight, after.heldout * before.weight)


def joint_errors(residual: Array, bench: Workbench) -> Array:
    """(n,) relative error per joint."""
    return np.array([relative_error(residual[:, [j]], bench.reference[:, [j]]) for j in range(residual.shape[1])])


def ready(proposed: Sequence[Candidate], robot: Robot, effects: frozenset[tuple[str, str]]) -> list[Candidate]:
    """Candidates not yet in the model whose basis (what they correct) is in it.

    A law that is akin to one that was found is no addition to that: it may take its place (``nested``). Some laws wait
    for what they contain.
    """
    present = effects | {(e.type, e.at) for e in robot.effects}
    return [
        c
        for c, law in ((c, catalogue()[c.effect]) for c in proposed)
        if (c.effect, c.place.address) not in present
        and (c.builds_on is None or (c.builds_on, c.place.address) in present)
        and (law.opens or any((e, c.place.address) in present for e in law.generalises))
        and not any(at == c.place.address and akin(c.effect, other) for other, at in effects)
    ]


def akin(one: str, other: str) -> bool:
    """Whether two effects contain one another, or a third: Coulomb's law, say, that of Dahl, and that of LuGre."""
    first, second = ({effect, *catalogue()[effect].generalises} for effect in (one, other))
    return one != other and bool(first & second)
