"""One explanation of a recording: the model with some effects added, fitted, and how it does held out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from symdyn.base.errors import NumericalError
from symdyn.numeric.candidates import Candidate, Key, bounded, bounds, fitted_parameters
from symdyn.numeric.decomposition import pseudo_inverse
from symdyn.numeric.effects_fit import EffectsFit, Fitted, Found
from symdyn.numeric.findings import Errors, Estimate
from symdyn.numeric.fitting import Fit, joint_weight, relative_error
from symdyn.numeric.laws import Laws
from symdyn.numeric.observation import KEPT, low_pass
from symdyn.numeric.position_spectrum import motion_cutoff
from symdyn.numeric.regression import fit_linear, likelier, log_loss
from symdyn.numeric.sampling import left_by_sampling
from symdyn.numeric.scan import WAVES
from symdyn.numeric.search import EARNS
from symdyn.numeric.sizes import sizes
from symdyn.numeric.verdict import NEGLIGIBLE
from symdyn.numeric.workbench import Workbench
from symdyn.spec.effect_schema import ParameterSchema, Scan
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

LEVEL = 0.01  # significance of a gain
CERTAIN = float(stats.norm.isf(LEVEL / 2.0))  # standard errors from null

SPREAD = 1.0  # a model's parameters are off by up to so much of their values, unless a recording tells otherwise
WEIGHINGS = 8  # of a fit, unless weights settle before
FAR = 3.0  # standard deviations that a parameter is thought to be off: beyond that it is suspect
MUCH = 2.0  # times as little is left at some joint
EVEN = 0.2  # relative change of weights that are settled
LITTLE = 0.02  # of what a law takes off: less does not tell it from another one at its place
CARRIES = 0.01  # of the inertia that swings, that what carries it has at least
SCALES = frozenset(
    {Scan.SPEED, Scan.TURNOVER, Scan.DISPLACEMENT, Scan.GROWTH, Scan.STEEPNESS, Scan.ANGLE_ORDER, Scan.FREQUENCY}
)
SPECK = 1e-6  # where a parameter that is none begins, to be one (gravity, in m/s^2)


@dataclass(frozen=True, slots=True, eq=False)
class Revised:
    """Something that the model or its sensors were told wrong, set right; ``names``: own parameters that do so."""

    effect: str
    title: str
    place: str
    values: Mapping[str, Estimate] = field(default_factory=dict)  # of an effect to be written
    names: Mapping[str, str] = field(default_factory=dict)  # by what a finding calls them

    @property
    def sensor(self) -> str | None:
        """The joint whose sensor, or drive, it is; None where numbers of the model were set right."""
        return None if self.names else self.place


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
    ended: bool = True  # whether its fits did so by themselves: others may still creep along a valley

    @property
    def effects(self) -> frozenset[Key]:
        return frozenset(c.key for c, _ in self.found)


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

    @property
    def _fit(self) -> EffectsFit:
        return EffectsFit(self.robot, self.laws, self.own, self.unknown, self.spread)

    def explain(self, found: Found = (), near: Explanation | None = None) -> Explanation:
        """Fit the model with the effects found, from the values of an explanation ``near`` it, if there is one.

        Where that one's parameters had gone astray, taking up much of what is found now, and the fit creeps back from
        there, it begins with the model as given, too, and the likelier one is taken.
        Raises NumericalError if the fit does not settle.
        """
        if near is None or not self.far(near.fit):
            return self.one_fit(found, near)
        try:
            done = self.one_fit(found, near)
        except NumericalError:
            return self.one_fit(found, None)
        if done.ended or np.all(done.weight <= MUCH * near.weight):
            return done
        return min(done, self.one_fit(found, None), key=lambda each: log_loss(each.training))

    def far(self, fit: Fit) -> list[str]:
        """The model's own parameters that ran to a bound, or far from the model's value, in the order of the fit."""
        limits, known, told = bounds(self.robot), sizes(self.robot), []
        watched = set(self.own) - self.unknown
        for name in (n for n in fit.names if n in watched):
            at = self.bench.index[name]
            value, given = float(fit.p[at]), float(self.bench.kernel.values[at])
            low = name in limits and value <= limits[name][0]
            if low or abs(value - given) > FAR * SPREAD * known.get(name, abs(given)) > 0.0:
                told.append(name)
        return told

    def one_fit(self, found: Found, near: Explanation | None) -> Explanation:
        """One fit, from an explanation, or from the model as given where there is none.

        The weight of each joint follows the size of what is left there, until that is even: where it falls much, as
        something is found, the joint hardly counted before.
        """
        p, weight = self.bench.kernel.values, np.ones(self.bench.effort.shape[1])
        known: dict[str, Fitted] = {}
        if near is not None:
            p, weight = near.fit.p, near.weight
            known = {c.label: f for (c, _), f in zip(near.found, near.fitted, strict=True)}
        state = [known.get(c.label, Fitted((0.0,) * len(c.linear), shapes)) for c, shapes in found]
        fit, ended = self._fit, True
        for _ in range(WEIGHINGS):
            weighed = weight
            p, state, by_itself = fit.settled(found, p, state, weighed)
            ended = ended and by_itself
            weight = joint_weight(fit.residual(self.laws, found, p, state), self.bench.reference)
            if np.all(np.abs(weight - weighed) <= EVEN * weighed):
                break
        training, design = fit.residual(self.laws, found, p, state), fit.design(self.laws, found, p, state)
        last = fit_linear(design * weight[:, None], training * weight)
        names = [*self.own, *(c.parameter(s) for c, _ in found for s in (*c.linear, *c.shapes))]
        done = Fit(tuple(names), p, last)
        return Explanation(
            found, done, tuple(state), weight, design, training, fit.residual(self.judged, found, p, state), ended
        )

    def residual(self, laws: Laws, of: Explanation) -> Array:
        """(K, n) of another recording, or the same in another band."""
        return self._fit.residual(laws, of.found, of.fit.p, of.fitted)

    def design(self, laws: Laws, of: Explanation) -> Array:
        """(K, n, k) columns of all that was fitted, on another recording, or on the same in another band."""
        return self._fit.design(laws, of.found, of.fit.p, of.fitted)

    def errors(self, of: Explanation) -> Errors:
        """Relative errors of the effort."""
        return Errors(
            relative_error(of.training, self.bench.reference), relative_error(of.heldout, self.judge.reference)
        )

    def nothing_left(self, of: Explanation) -> bool:
        """Whether no effect could take off enough to be told."""
        seen = joint_errors(of.training, self.bench), joint_errors(of.heldout, self.judge)
        return bool(np.all(np.concatenate(seen) <= NEGLIGIBLE))

    def earns(
        self, before: Explanation, after: Explanation, sensor: str | None = None, bare: Explanation | None = None
    ) -> bool:
        """Held-out error falls by more than chance, over all, and at some joint by enough to matter.

        What a joint's ``sensor`` shows enters every equation, and some of them may like it by chance: it must matter
        in that joint's own, or over all. Where it is open which of two laws is there, ``bare`` has neither: then what
        matters is a part of what such a law takes off.
        """
        gain, p_value = heldout_gain(before, after)
        falls = gain > 0 and self.errors(after).heldout < self.errors(before).heldout
        old, new = (self._judged(e.heldout, sensor) for e in (before, after))
        takes = np.sqrt(np.maximum(old**2 - new**2, 0.0))
        least = NEGLIGIBLE if bare is None else np.minimum(NEGLIGIBLE, LITTLE * self._judged(bare.heldout, sensor))
        enough = (new <= (1.0 - EARNS) * old) & (takes > least)
        if not falls or p_value >= LEVEL or not enough.any():
            return False
        return bool(np.any(enough & (takes > self._judged(self.left_by_sampling(after), sensor))))

    def _judged(self, residual: Array, sensor: str | None) -> Array:
        """Relative errors held out: of every joint; of a sensor's own joint, and over all."""
        each = joint_errors(residual, self.judge)
        if sensor is None:
            return each
        return np.array([each[self.joints.index(sensor)], relative_error(residual, self.judge.reference)])

    def left_by_sampling(self, of: Explanation) -> Array:
        """(K, n) of held-out data, what the time between samples leaves though nothing is missing."""
        return left_by_sampling(self.judged, of.found, of.fitted, of.fit.p)

    def confirms(
        self, candidate: Candidate, before: Explanation, after: Explanation, bare: Explanation | None = None
    ) -> bool:
        """Whether a candidate that ``after`` has beside, or in the place of something in, ``before`` earns its place.

        What swings must do so below the frequency at which the motion of its joint sinks into noise: beyond, it is a
        filter that lets less of the noise of accelerations through. And where all of that motion is kept: it makes up
        for what a filter takes off them. And it swings on what has an inertia, too.
        """
        if candidate.swings:
            seen, joint = self.judge.observation, self.laws.joint(candidate)
            held = self.bench.kernel.mass_matrix_p(np.median(seen.q, axis=0), after.fit.p)[joint, joint]
            swinging = after.fitted[[c for c, _ in after.found].index(candidate)].coefficients[0]
            if self.bounded(candidate, after) or held < CARRIES * swinging:
                return False
            known = motion_cutoff(seen.measured[:, [joint]], seen.segments, seen.rate)
            known = min(known, KEPT * float(seen.motions[joint]))
            rate = self.judge.samples_per_period * self.judge.edge
            before, after = (replace(each, heldout=low_pass(each.heldout, rate, known)) for each in (before, after))
        return self.earns(before, after, bare=bare)

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

    def apart(self, candidate: Candidate, of: Explanation) -> bool:
        """Whether a wave is one of its own: over the motion it has ``WAVES`` more or fewer than any other found there.

        Two that are closer are one, whose size is not the same everywhere.
        """
        if not candidate.repeats:
            return True
        fitted = {c.key: f for (c, _), f in zip(of.found, of.fitted, strict=True) if c.law == candidate.law}
        own = fitted.pop(candidate.key).shapes[0]
        turns = float(np.ptp(self.bench.observation.q[:, self.laws.joint(candidate)])) / (2.0 * np.pi)
        return all(abs(own - other.shapes[0]) * turns >= WAVES for other in fitted.values())

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
