"""The model and the effects found, fitted together: parameters, coefficients, and shapes that no line holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.candidates import Candidate, bounds, candidate_bounds
from symdyn.numeric.fitting import eased, minimise
from symdyn.numeric.laws import Laws
from symdyn.numeric.regression import solve_linear, times, without
from symdyn.numeric.sizes import sizes
from symdyn.physics import load_dependent
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

SHAPE_STEPS = 12  # Gauss-Newton steps of the shape parameters
TURNS = 4  # of a last fit with friction by load, in each of which the load follows: a turn leaves a tenth
STEPS = 5  # of a fit of all else, between two of those
SETTLED = 1e-5  # relative fall of the loss below which they have settled

Found = tuple[tuple[Candidate, tuple[float, ...]], ...]  # candidates with the scanned values of their shape parameters


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """Values of one found effect: of its linear parameters, and of its shapes."""

    coefficients: tuple[float, ...]
    shapes: tuple[float, ...]


@dataclass(frozen=True, slots=True, eq=False)
class EffectsFit:
    """``own`` parameters of a robot, thought to be off by ``spread``, are fitted with what was found on top of it."""

    robot: Robot
    laws: Laws  # training
    own: tuple[str, ...]  # of which nothing is thought where they are ``unknown``
    unknown: frozenset[str]
    spread: float

    def settled(self, found: Found, p: Array, state: list[Fitted], weight: Array) -> tuple[Array, list[Fitted], bool]:
        """Shape parameters by Gauss-Newton around the fit of all others, of which a few steps do until they settle.

        Also whether all the fits of all others ended by themselves: one that did not may still be creeping.
        """
        weighed = p
        count = sum(len(c.shapes) for c, _ in found)
        p, state, loss, ended = self._linear(found, p, state, weight, weighed, turns=1 if count else TURNS)
        for _ in range(SHAPE_STEPS if count else 0):
            design = self.design(self.laws, found, p, state)
            residual = self.residual(self.laws, found, p, state)
            step = self._step(found, state, design * weight[:, None], residual * weight)
            changes = [step[places] for places in self._shape_places(found)]
            for scale in (1.0, 0.25, 0.0625):
                moved = [
                    Fitted(f.coefficients, self._moved(self.laws.room(c, scanned), f.shapes, scale * change))
                    for (c, scanned), f, change in zip(found, state, changes, strict=True)
                ]
                trial_p, trial, lower, _ = self._linear(found, p, moved, weight, weighed, turns=1, steps=STEPS)
                if lower < loss:
                    break
            else:
                break
            fall, p, state, loss = loss - lower, trial_p, trial, lower
            if fall <= SETTLED * loss:
                break
        if count:
            p, state, _, last = self._linear(found, p, state, weight, weighed, turns=TURNS)
            ended = ended and last
        return p, state, ended

    def _step(self, found: Found, state: Sequence[Fitted], design: Array, residual: Array) -> Array:
        """Of everything; a shape parameter that stands at the end of its room, and would go further, stays there."""
        free = np.ones(design.shape[2], dtype=bool)
        while True:
            step = np.zeros(len(free))
            step[free] = solve_linear(design[:, :, free], residual)
            ends = [
                at
                for (candidate, scanned), f, places in zip(found, state, self._shape_places(found), strict=True)
                for at, (low, high), value in zip(places, self.laws.room(candidate, scanned), f.shapes, strict=True)
                if (value <= low and step[at] < 0.0) or (value >= high and step[at] > 0.0)
            ]
            if not ends:
                return step
            free[ends] = False

    @staticmethod
    def _moved(room: Sequence[tuple[float, float]], shapes: tuple[float, ...], step: Array) -> tuple[float, ...]:
        return tuple(
            float(np.clip(value + change, low, high))
            for (low, high), value, change in zip(room, shapes, step, strict=True)
        )

    def _shape_places(self, found: Found) -> list[range]:
        """Where in the order of the design the shapes of each effect found are."""
        at, places = len(self.own), []
        for candidate, _ in found:
            first = at + len(candidate.linear)
            at = first + len(candidate.shapes)
            places.append(range(first, at))
        return places

    def _linear(
        self,
        found: Found,
        p: Array,
        state: list[Fitted],
        weight: Array,
        weighed: Array,
        turns: int,
        steps: int | None = None,
    ) -> tuple[Array, list[Fitted], float, bool]:
        """Everything but the shapes, fitted: also the loss that is left, with a weight for parameters ``weighed``, and
        whether it ended by itself.

        In so many ``turns`` where friction follows the load.
        """
        limits, known = bounds(self.robot), sizes(self.robot)
        names = [c.parameter(s) for c, _ in found for s in c.linear]
        for candidate, _ in found:
            limits |= candidate_bounds(candidate)
        start = np.array([value for f in state for value in f.coefficients])
        begun = self._begun(self.laws, found, state)
        names += [f"begun_{i}" for i in range(begun.shape[2])]
        start = np.concatenate([start, np.zeros(begun.shape[2])])
        loaded = any(candidate.effect in load_dependent() for candidate, _ in found)
        ended = True
        for _ in range(turns if loaded else 1):
            added = self._added(self.laws, found, state, p)
            p, start, done_so = minimise(
                self.laws.bench,
                p,
                self.own,
                np.concatenate([added, begun], axis=2),
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
            ended = ended and done_so
        done, at = [], 0
        for f in state:
            count = len(f.coefficients)
            done.append(Fitted(tuple(float(x) for x in start[at : at + count]), f.shapes))
            at += count
        weight = weight * (self.laws.bench.passive.inertia(weighed) / self.laws.bench.passive.inertia(p))
        added = self._added(self.laws, found, done, p) if loaded else added
        return p, done, float(np.sum((self._left(self.laws, done, p, added, begun) * weight) ** 2)), ended

    def _added(self, laws: Laws, found: Found, state: Sequence[Fitted], p: Array) -> Array:
        """(K, n, e) columns of the linear parameters of all effects found."""
        parts = [laws.spread(c, laws.columns(c, f.shapes, p)) for (c, _), f in zip(found, state, strict=True)]
        return np.concatenate([np.zeros((*laws.bench.effort.shape, 0)), *parts], axis=2)

    def residual(self, laws: Laws, found: Found, p: Array, state: Sequence[Fitted]) -> Array:
        return self._left(laws, state, p, self._added(laws, found, state, p), self._begun(laws, found, state))

    def _left(self, laws: Laws, state: Sequence[Fitted], p: Array, added: Array, begun: Array) -> Array:
        """(K, n) the same with columns of the effects, and of how their states began, that are known."""
        coefficients = np.array([value for f in state for value in f.coefficients])
        return without(laws.bench.left(p, self.own) - times(added, coefficients), begun)

    @staticmethod
    def _begun(laws: Laws, found: Found, state: Sequence[Fitted]) -> Array:
        """(K, n, m) columns of how hidden states began, where that goes on for long."""
        parts = [np.zeros((*laws.bench.effort.shape, 0))]
        for (candidate, _), f in zip(found, state, strict=True):
            parts.append(laws.spread(candidate, laws.starts(candidate, f.shapes)))
        return np.concatenate(parts, axis=2)

    def design(self, laws: Laws, found: Found, p: Array, state: Sequence[Fitted]) -> Array:
        """(K, n, k) columns of all that is fitted, in the order of the names of a fit."""
        own = laws.bench.moved(p, self.own)
        if laws.bench.passive.joints:
            own = own + eased(laws.bench, p, self.own, self.residual(laws, found, p, state))
        parts = [own]
        for (candidate, _), f in zip(found, state, strict=True):
            parts.append(laws.spread(candidate, laws.columns(candidate, f.shapes, p)))
            parts.append(laws.spread(candidate, laws.slopes(candidate, f.coefficients, f.shapes, p)))
        return without(np.concatenate(parts, axis=2), self._begun(laws, found, state))
