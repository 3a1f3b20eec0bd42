"""T-optimal design: the motion on which the second-best explanation fails most (Atkinson and Fedorov 1975)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import InputError, Problem
from symdyn.numeric.experiment.explanations import Explained
from symdyn.numeric.experiment.limits import Limits, widened
from symdyn.numeric.experiment.motions import Family, Motion
from symdyn.numeric.experiment.searching import feasible, maximised, members, pool, samples
from symdyn.numeric.experiment.separation import Noise, lost, refitted

Array = NDArray[np.float64]
Progress = Callable[[str], None]

SEPARATES = 10.0  # nats that an experiment should promise: odds of more than 20 000 to 1
ROUNDS = 3  # of motion against refit (Shimizu and Aiyoshi 1980), where a refit is not linear
HONEST = 0.9  # where the full refit leaves less than this part of what a linear one left, the search goes on with it
EVALUATIONS = 1200  # of a round
SAME = 1e-6  # part of the effort: laws that differ differ by more than this on some motion
LONGEST = 20.0  # times the duration that a longer experiment may be proposed for
WIDENED = ("travel", "speed", "effort")
WIDER = (4.0, 16.0)  # times the travel, speed or effort that are tried where nothing within the limits tells


@dataclass(frozen=True, slots=True)
class Direction:
    """``nats`` that the other explanation loses where ``truth`` (0 or 1 of the pair) holds.

    ``nested``: none on any motion, because the other holds the truth as a special case.
    """

    truth: int
    nats: float
    nested: bool


@dataclass(frozen=True, slots=True, eq=False)
class Design:
    """``separation`` in nats is the lesser of the directions that are not nested; ``usual`` the median motion's.

    ``wider`` is what would separate where this motion does not: "time", "travel", "speed", "effort" or all
    of them times ``factor``; "" where none would.
    """

    point: Array  # of the family
    motion: Motion
    separation: float
    directions: tuple[Direction, Direction]
    usual: float
    wider: str = ""
    factor: float = 1.0

    @property
    def separates(self) -> bool:
        return self.separation >= SEPARATES


@dataclass(frozen=True, slots=True, eq=False)
class _Contest:
    """Two explanations on all motions of a family; ``at`` are the parameters about which each is refitted."""

    pair: tuple[Explained, Explained]
    family: Family
    noise: Noise
    at: tuple[list[Array], list[Array]]

    def nats(self, point: Array, truth: int) -> float:
        motion = feasible(self.family, point, self.pair)
        if motion is None:
            return 0.0
        return lost(self.pair[truth], self.pair[1 - truth], motion, self.noise, self.at[1 - truth])

    def least(self, point: Array, truths: Sequence[int]) -> float:
        return min(self.nats(point, truth) for truth in truths)

    def strength(self, point: Array) -> float:
        """The efforts themselves, in nats."""
        motion = feasible(self.family, point, self.pair)
        if motion is None:
            return 0.0
        return self.noise.nats(self.pair[0].effort(motion) * self.noise.weight, self.family.duration)


def design(
    pair: tuple[Explained, Explained],
    limits: Limits,
    noise: Noise,
    duration: float,
    *,
    seed: int = 0,
    evaluations: int = EVALUATIONS,
    progress: Progress = lambda _: None,
) -> Design:
    """The motion of ``duration`` s within the limits that tells the pair apart best; the same seed, the same motion.

    Raises InputError (SD333) where even rest needs more effort than the limits allow.
    """
    family = Family(limits, duration)
    contest = _Contest(pair, family, noise, ([pair[0].p], [pair[1].p]))
    points = pool(family, seed)
    progress("comparing the explanations on motions of all kinds")
    strength = max(contest.strength(point) for point in points)
    if strength == 0.0:
        raise InputError(Problem("SD333", "every motion needs more effort than the limits allow"))
    table = np.array([[contest.nats(point, truth) for truth in (0, 1)] for point in points])
    nested = [bool(table[:, truth].max() <= SAME**2 * strength) for truth in (0, 1)]
    truths = [truth for truth in (0, 1) if not nested[truth]]
    if not truths:
        motion = family.motion(points[0], samples(family))
        return Design(points[0], motion, 0.0, (Direction(0, 0.0, True), Direction(1, 0.0, True)), 0.0)
    least = table[:, truths].min(axis=1)
    point, motion, told = _searched(contest, points[np.argsort(-least)], truths, evaluations, seed, progress)
    directions = (Direction(0, told.get(0, 0.0), nested[0]), Direction(1, told.get(1, 0.0), nested[1]))
    separation = min(told.values())
    wider, factor = ("", 1.0) if separation >= SEPARATES else _what_would(contest, (point, *points), truths, separation)
    return Design(point, motion, separation, directions, float(np.median(least)), wider, factor)


def _searched(
    contest: _Contest, points: Array, truths: Sequence[int], evaluations: int, seed: int, progress: Progress
) -> tuple[Array, Motion, dict[int, float]]:
    """Motion against refit, in turns: a refit that the linear ones had not seen is held against the next motion."""
    best: tuple[float, Array, Motion, dict[int, float]] | None = None
    population = points[: members(contest.family)]
    for number in range(ROUNDS):
        progress(f"searching the motion, round {number + 1}")

        def objective(point: Array) -> float:
            return math.log(max(contest.least(point, truths), 1e-12))

        point = maximised(objective, population, evaluations, seed)
        motion = feasible(contest.family, point, contest.pair, 2 * samples(contest.family))
        assert motion is not None  # the objective of such a point is the least there is, and the pool has better ones
        told, fooled = {}, False
        for truth in truths:
            believed = lost(contest.pair[truth], contest.pair[1 - truth], motion, contest.noise, contest.at[1 - truth])
            told[truth], p = refitted(contest.pair[truth], contest.pair[1 - truth], motion, contest.noise)
            if told[truth] < HONEST * believed:
                contest.at[1 - truth].append(p)
                fooled = True
        if best is None or min(told.values()) > best[0]:
            best = (min(told.values()), point, motion, told)
        if not fooled:
            break
        population = np.concatenate([population[:-1], [best[1]]])
    assert best is not None
    return best[1:]


def _what_would(
    contest: _Contest, points: Sequence[Array], truths: Sequence[int], separation: float
) -> tuple[str, float]:
    """More time, if that is enough; else the one limit that, widened, gives most, or all of them, if that is."""
    if separation * LONGEST >= SEPARATES:
        return "time", SEPARATES / separation
    for choices in ([(word,) for word in WIDENED], [WIDENED]):
        for factor in WIDER:
            gains = {words: _within_wider(contest, points, truths, words, factor) for words in choices}
            best = max(gains, key=lambda words: gains[words])
            if gains[best] >= SEPARATES:
                return _joined(best), factor
    return "", 1.0


def _within_wider(
    contest: _Contest, points: Sequence[Array], truths: Sequence[int], words: Sequence[str], factor: float
) -> float:
    """The best of the points, with more of these."""
    limits = contest.family.limits
    for word in words:
        limits = widened(limits, word, factor)
    wide = _Contest(contest.pair, Family(limits, contest.family.duration), contest.noise, contest.at)
    return max(wide.least(point, truths) for point in points)


def _joined(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
