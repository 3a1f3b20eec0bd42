"""Forward selection of missing effects: chosen on training data by cross-validation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.decomposition import least_squares, svd
from symdyn.numeric.laws import Laws
from symdyn.numeric.regression import RANK_TOLERANCE, flat, likelier, log_loss, times, triangle
from symdyn.numeric.scan import WAVES, axes, grid, screened
from symdyn.numeric.shape_space import ShapeSpace
from symdyn.spec.effect_schema import ParameterSchema, Scan

Array = NDArray[np.float64]

FOLDS = 8  # contiguous blocks, so that a block's neighbours do not give it away
LEAST = 1e-4  # of its power, that a force must take off the error beyond another to be preferred to a smaller one
HOPE = 0.1  # of the best gain on any grid: a candidate with less is not looked at between the points of its own
HOPEFUL = 4  # of the effects with several shape parameters, the best are worth a closer search
TIE = 0.05  # explanations that the best one improves on with a larger p-value are rivals
HALF = 0.5  # of what a law that swings takes off the loss
EARNS = 0.03  # an effect that takes less than this part off the error is not worth a line in a model
SAME = 1e-3  # part of a law that another one must leave for the two to differ; noise hides less
SEEN = 1e-10  # of a direction's power: a fold that holds all but this much of it holds it alone


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """One candidate, tried: its best shape values and its cross-validated errors."""

    candidate: Candidate
    shapes: tuple[float, ...]
    tests: int  # how many shape values were tried
    estimate: Array  # of its linear parameters, all training data
    errors: Array  # (K, n), weighted
    gain: float  # of the log-likelihood per sample, doubled
    p_value: float  # of "no gain", one-sided

    @property
    def loss(self) -> float:
        return log_loss(self.errors)

    @property
    def admissible(self) -> bool:
        """Within the bounds of its parameters: friction that drives is no friction."""
        return within(self.candidate.linear, self.estimate)


@dataclass(frozen=True, slots=True)
class Scanned:
    """The best point on a candidate's grid, and its loss less that of the current explanation."""

    candidate: Candidate
    grid: list[tuple[float, ...]]
    best: tuple[float, ...]
    loss: float


def within(schemas: Sequence[ParameterSchema], values: Array) -> bool:
    """Whether values are within the bounds of their parameters."""
    return all(
        (s.lower is None or value >= s.lower) and (s.upper is None or value <= s.upper)
        for s, value in zip(schemas, values, strict=True)
    )


class Search:
    """Tries candidates on top of a current explanation, linearised at its parameters ``p``.

    ``residual`` (K, n) and ``design`` (K, n, k) are those of the explanation, ``weight`` is (n,). The design is
    made orthonormal once; a candidate then costs products with its few columns, and leaving a block
    out is a small matrix less that block's share.
    """

    def __init__(self, laws: Laws, p: Array, residual: Array, design: Array, weight: Array) -> None:
        self.laws, self.p, self.weight = laws, p, weight
        self.target = residual * weight
        count, n = self.target.shape
        self._blocks = [slice(int(b[0]), int(b[-1]) + 1) for b in np.array_split(np.arange(count), FOLDS) if len(b)]
        given = flat(design * weight[:, None])
        u, size, _ = svd(given / (np.linalg.norm(given, axis=0) + 1e-300), full_matrices=False)
        basis = u[:, size > RANK_TOLERANCE * size.max(initial=0.0)]
        self._basis = basis.reshape(count, n, -1)
        self._at = [np.ascontiguousarray(self._basis[:, joint]) for joint in range(n)]
        self._left = (self.target.reshape(-1) - basis @ (basis.T @ self.target.reshape(-1))).reshape(count, n)
        self._losses: dict[str, tuple[list[tuple[float, ...]], list[float]]] = {}  # of each candidate's grid
        self._folded: dict[int, Array] = {}  # of each joint: what all the others say
        self._shares = [self._gram(self._basis[b], self._basis[b]) for b in self._blocks]
        self.errors = self._cross_validated(np.zeros((count, n, 0)))

    def trial(self, candidate: Candidate, waves: float = WAVES) -> Trial:
        """The candidate at the best values of its shape parameters; ``waves`` that the travel must hold, at least."""
        return self.closer(self.scan(candidate, waves))

    def scan(self, candidate: Candidate, waves: float = WAVES) -> Scanned:
        """The same on the grid of those values."""
        joint = self.laws.joint(candidate)
        values = grid(candidate, joint, self.laws.bench, waves)
        tried = screened(candidate, values, self._left[:, joint], joint, self.laws.bench)
        losses = [self._training_loss(candidate, value) for value in tried]
        self._losses[candidate.label] = tried, losses
        return Scanned(candidate, values, tried[int(np.argmin(losses))], min(losses))

    def closer(self, scanned: Scanned) -> Trial:
        """The best between the neighbours on the grid, one parameter after the other."""
        return self.at(scanned.candidate, self._between(scanned), len(scanned.grid))

    def at(self, candidate: Candidate, shapes: tuple[float, ...], tests: int = 1) -> Trial:
        """The candidate at given values of them."""
        columns = self._columns(candidate, shapes)
        apart = self._apart(columns, self.laws.joint(candidate))
        estimate = self._solve(apart, columns)
        errors = self._cross_validated(self._orthonormal(apart, columns))
        gain, p_value = likelier(self.errors, errors)
        return Trial(candidate, shapes, tests, estimate, errors, gain, p_value)

    def polished(self, trial: Trial) -> Trial:
        """The same with all its shape parameters moved together (variable projection), from the best of the grid."""
        candidate = trial.candidate
        scanned = axes(candidate, self.laws.joint(candidate), self.laws.bench)
        space = ShapeSpace(candidate.shapes, scanned)
        values, losses = self._losses[candidate.label]
        starts = [trial.shapes, *space.apart(values, losses, trial.shapes)]
        found = [space.least_squares(lambda x: self._unexplained(candidate, x), start) for start in starts]
        tried = [trial, *(self.at(candidate, shapes, trial.tests) for shapes in found)]
        return min(tried, key=lambda t: (not t.admissible, t.loss))

    def _unexplained(self, candidate: Candidate, shapes: tuple[float, ...]) -> Array:
        """(K + r + 1,) what the best size of this shape leaves of all training data, folded at the other joints."""
        columns, joint = self._columns(candidate, shapes), self.laws.joint(candidate)
        own, elsewhere = self._at[joint], self._elsewhere(joint)
        held = own.T @ columns
        apart = np.concatenate([columns - own @ held, -elsewhere[:, :-1] @ held])
        left = np.concatenate([self._left[:, joint], elsewhere[:, -1]])
        made = _orthonormal(apart, columns)  # of no columns, where the model's own take this shape up
        return np.asarray(left - made @ (made.T @ left))

    def _elsewhere(self, joint: int) -> Array:
        """(r + 1, r + 1) triangle of the basis, and of what the explanation leaves, at all other joints.

        What a law at one joint does to them goes through the basis alone.
        """
        if joint not in self._folded:
            others = [np.column_stack([at, left]) for at, left in zip(self._at, self._left.T, strict=True)]
            stacked = np.concatenate([np.zeros((0, others[joint].shape[1])), *others[:joint], *others[joint + 1 :]])
            self._folded[joint] = triangle(stacked)
        return self._folded[joint]

    def errors_beside(self, laws: Sequence[Candidate]) -> Array:
        """(K, n) cross-validated errors with several laws without a shape, all at one place."""
        columns = np.concatenate([self._columns(law, ()) for law in laws], axis=1)
        return self._cross_validated(self._orthonormal(self._apart(columns, self.laws.joint(laws[0])), columns))

    def errors_with(self, columns: Array) -> Array:
        """(K, n) cross-validated errors with columns (K, n, k) that act at all joints, unweighted."""
        added, basis = flat(columns * self.weight[:, None]), flat(self._basis)
        apart = _orthonormal(added - basis @ (basis.T @ added), added)
        return self._cross_validated(apart.reshape(*columns.shape[:2], -1))

    def contains(self, larger: Trial, smaller: Trial) -> bool:
        """Whether one candidate's law is the other's with more freedom, on this recording."""
        if larger.candidate.size <= smaller.candidate.size:
            return False
        wide, narrow = (
            self._apart(self._columns(t.candidate, t.shapes), self.laws.joint(t.candidate)) for t in (larger, smaller)
        )
        wide, narrow = wide.reshape(-1, wide.shape[2]), narrow.reshape(-1, narrow.shape[2])
        left = narrow - wide @ least_squares(wide, narrow, rcond=RANK_TOLERANCE)
        size = np.linalg.norm(self._columns(smaller.candidate, smaller.shapes), axis=0)
        return bool(np.all(np.linalg.norm(left, axis=0) <= SAME * size))

    def _between(self, scanned: Scanned) -> tuple[float, ...]:
        candidate, best, lowest = scanned.candidate, scanned.best, scanned.loss
        for i in range(len(best)):
            axis = sorted({value[i] for value in scanned.grid})
            at = int(np.argmin(np.abs(np.array(axis) - best[i])))
            low, high = axis[max(at - 1, 0)], axis[min(at + 1, len(axis) - 1)]
            if high <= low:
                continue

            def loss(value: float, i: int = i, best: tuple[float, ...] = best) -> float:
                return self._training_loss(candidate, (*best[:i], float(value), *best[i + 1 :]))

            found = optimize.minimize_scalar(
                loss, bounds=(low, high), method="bounded", options={"xatol": 1e-3 * float(high - low)}
            )
            if found.fun < lowest:
                best, lowest = (*best[:i], float(found.x), *best[i + 1 :]), float(found.fun)
        return best

    def _training_loss(self, candidate: Candidate, shapes: tuple[float, ...]) -> float:
        """Loss on all training data less that of the current explanation: what the columns take off it.

        A direction that asks for a negative size is the opposite one. Where the model's own parameters take part of
        it up, many directions do as well: the one that asks for the least force is meant.
        """
        columns, joint = self._columns(candidate, shapes), self.laws.joint(candidate)
        size = np.linalg.norm(columns, axis=0) + 1e-300
        unit, own = columns / size, self._at[joint]
        whole, held, aim = unit.T @ unit, own.T @ unit, unit.T @ self._left[:, joint]
        # Of what the explanation does not hold of columns, the products follow from those of the whole: they stand at
        # one joint, and what is left has none with what it holds.
        values, vectors = np.linalg.eigh(whole - held.T @ held)
        kept = values > RANK_TOLERANCE**2
        along = vectors[:, kept].T @ aim
        gain = float(np.sum(along**2 / values[kept]))
        if all(s.scan is not Scan.ANGLE for s in candidate.shapes):
            return -gain
        estimate = vectors[:, kept] @ (along / values[kept])
        force = float(estimate @ whole @ estimate)
        return LEAST * force - gain if within(candidate.linear, estimate / size) else 0.0

    def _columns(self, candidate: Candidate, shapes: tuple[float, ...]) -> Array:
        """(K, k) weighted, at the candidate's joint."""
        return np.asarray(self.laws.columns(candidate, shapes, self.p) * self.weight[self.laws.joint(candidate)])

    def _apart(self, columns: Array, joint: int) -> Array:
        """(K, n, k) what the current explanation does not hold of columns (K, k) at a joint."""
        apart = -times(self._basis, self._at[joint].T @ columns)
        apart[:, joint] += columns
        return apart

    @staticmethod
    def _orthonormal(apart: Array, columns: Array) -> Array:
        """(K, n, r) an orthonormal basis of that."""
        return _orthonormal(flat(apart), columns).reshape(*apart.shape[:2], -1)

    def _solve(self, apart: Array, columns: Array) -> Array:
        alone = flat(apart)
        size = np.linalg.norm(columns, axis=0) + 1e-300
        return np.asarray(least_squares(alone / size, self._left.reshape(-1), rcond=RANK_TOLERANCE) / size)

    @staticmethod
    def _gram(a: Array, b: Array) -> Array:
        return np.asarray(np.tensordot(a, b, axes=((0, 1), (0, 1))))

    def _cross_validated(self, added: Array) -> Array:
        """(K, n) errors of each sample under the fit to the other blocks; ``added`` is orthonormal to the design.

        Of an orthonormal whole, all blocks but one have the identity less that block's own products.
        """
        errors = np.empty_like(self.target)
        target = self.target[:, :, None]
        total = np.concatenate([self._gram(self._basis, target), self._gram(added, target)])[:, 0]
        for block, share in zip(self._blocks, self._shares, strict=True):
            base, more, aim = self._basis[block], added[block], target[block]
            across = self._gram(base, more)
            own = np.block([[share, across], [across.T, self._gram(more, more)]])
            sums = total - np.concatenate([self._gram(base, aim), self._gram(more, aim)])[:, 0]
            values, vectors = np.linalg.eigh(np.eye(len(own)) - own)
            kept = values > SEEN
            estimate = vectors[:, kept] @ ((vectors[:, kept].T @ sums) / values[kept])
            split = base.shape[2]
            errors[block] = self.target[block] - times(base, estimate[:split]) - times(more, estimate[split:])
        return errors


def _orthonormal(apart: Array, columns: Array) -> Array:
    """A basis of what is left of columns, of (m, k); what is nothing beside their own length is left out."""
    size = np.linalg.norm(columns, axis=0) + 1e-300
    vectors, values, _ = svd(apart / size, full_matrices=False)
    return np.asarray(vectors[:, values > RANK_TOLERANCE])


def rank(
    search: Search, proposed: Sequence[Candidate], level: float, progress: Callable[[str], None]
) -> tuple[list[Trial], list[Trial]]:
    """Trials that earn their place at significance ``level`` (Bonferroni over all that was tried).

    Returns (earning, best first; inadmissible ones that would have earned it). Explanations that
    cannot be told from the best (``TIE``), or nearly do as well, are ordered by how few numbers they bring.
    """
    scanned = []
    for candidate in proposed:
        progress(candidate.label)
        scanned.append(search.scan(candidate))
    least = HOPE * min((s.loss for s in scanned), default=0.0)
    tests = sum(len(s.grid) for s in scanned)
    trials = []
    for s in scanned:
        trial = search.closer(s) if s.loss <= least else search.at(s.candidate, s.best, len(s.grid))
        hasty = s.loss > least and trial.gain > 0 and trial.p_value * tests < level and not trial.admissible
        trials.append(search.closer(s) if hasty else trial)
    several = [t for t in trials if len(t.candidate.shapes) > 1 and t.gain > 0]
    for trial in sorted(several, key=lambda t: t.loss)[:HOPEFUL]:
        trials[trials.index(trial)] = search.polished(trial)
    earning = [t for t in trials if t.gain > 0 and t.p_value * tests < level]
    refused = [t for t in earning if not t.admissible]
    earning = sorted((t for t in earning if t.admissible), key=lambda t: t.loss)
    if earning:
        best = earning[0]
        tied = [t for t in earning if t is best or _tied(search, t, best, level)]
        tied.sort(key=lambda t: (t.candidate.size, t.loss))
        earning = tied + [t for t in earning if t not in tied]
    return _patient(earning, log_loss(search.errors)), refused


def _patient(earning: list[Trial], stands: float) -> list[Trial]:
    """In that order, but what swings behind all others, if one of them takes half as much off the loss.

    It answers to the whole motion, and so takes up a little of whatever is missing.
    """
    swinging = [t for t in earning if t.candidate.swings]
    others = [t for t in earning if t not in swinging]
    most, other = (max((stands - t.loss for t in each), default=0.0) for each in (swinging, others))
    return others + swinging if other > HALF * most else earning


def _tied(search: Search, trial: Trial, best: Trial, level: float) -> bool:
    """Whether the best cannot be told from a trial, or, at its place, takes too little off the error to matter.

    What the best one has beyond another that it contains must earn its place like any finding.
    """
    if trial.candidate.place == best.candidate.place:
        joint = search.laws.joint(best.candidate)
        sizes = [float(np.sum(t.errors[:, joint] ** 2)) for t in (trial, best)]
        if sizes[1] > (1.0 - EARNS) ** 2 * sizes[0]:
            return True
    return likelier(trial.errors, best.errors)[1] > (level if search.contains(best, trial) else TIE)
