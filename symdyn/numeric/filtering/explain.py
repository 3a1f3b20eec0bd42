"""Forward selection of missing effects where part of the machine is hidden: tried by likelihood, fitted, judged."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.filtering.beliefs import Beliefs, penalty
from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.budget import allowed
from symdyn.numeric.filtering.hypotheses import DELAYS, LATE_REFERENCE, MEMORIES
from symdyn.numeric.filtering.judged import (
    LEVEL,
    LIKELY,
    WORTH,
    Explanation,
    Step,
    contains,
    explained,
    heldout_p_value,
    price,
    that_earns,
)
from symdyn.numeric.filtering.late import absorbing, late, put_back, the_other_way
from symdyn.numeric.filtering.likelihood import MLFit, fit
from symdyn.numeric.filtering.model import Model, candidate_beliefs
from symdyn.numeric.filtering.score import Score, scores
from symdyn.numeric.filtering.side_by_side import side_by_side
from symdyn.numeric.filtering.stiff import that_show
from symdyn.numeric.gearing import joint_name
from symdyn.numeric.groups import same_place

Array = NDArray[np.float64]
Progress = Callable[[str], None]

TRIED = 5  # hypotheses that are fitted in full at each turn
TURNS = 2  # of such fits: where the most promising do not earn their place, the next ones may
PROMISING = 0.2  # of the largest expected gain: what promises less is not fitted
PARTS = (1.0, 0.5, 0.25, 0.1)  # of what a score test expects: where such a fit may start
SMALLER = (1e-2, 1e-3, 1e-4)  # where all of those are worse than nothing: a filter that chatters is slow, and lost
ROUGH, ROUNDS = 2.0, 6  # nats and rounds of a fit that only sorts


def with_effect(model: Model, current: Explanation, candidate: Candidate, shape: float | None, start: Array) -> MLFit:
    """The fit with one more effect, everything fitted again: roughly, to sort by.

    It starts where the fit without it stands, and, if parameters may have absorbed the effect there, also with those
    at the values that were given.
    """
    bench = current.fit.bench
    p = shaped(bench, current.fit.p, candidate, shape)
    suspects = absorbing(current)
    none = current.fit.loss - penalty(current.fit.p, bench.index, current.beliefs)
    starts = [begun(bench, p, candidate, start, none)]
    if suspects:
        starts.append(begun(bench, put_back(current, p), candidate, start))
    if _absorbed(model, current, candidate):
        starts[1:] = [late(current, starts[0], candidate.parameter(candidate.linear[0]))]
    beliefs = dict(current.beliefs) | candidate_beliefs(candidate, shape)

    def roughly(p: Array) -> MLFit:
        return fit(bench, p, beliefs, settled=ROUGH, most=ROUNDS)

    return min(side_by_side(roughly, starts), key=lambda fitted: fitted.loss)


def _absorbed(model: Model, current: Explanation, candidate: Candidate) -> bool:
    """Whether parameters went where they make up for such a delay.

    Those of a circuit do so for a late voltage; for a late reference all of the machine in the loop.
    """
    suspects = frozenset(absorbing(current))
    if candidate.effect != LATE_REFERENCE:
        suspects &= model.electrical
    return candidate.effect in DELAYS and bool(suspects)


def shaped(bench: FilterBench, p: Array, candidate: Candidate, shape: float | None) -> Array:
    """A copy of the parameters with a hypothesis's shape, if it has one."""
    moved = p.copy()
    if shape is not None:
        moved[[bench.index[candidate.parameter(schema)] for schema in candidate.shapes]] = shape
    return moved


def begun(bench: FilterBench, p: Array, candidate: Candidate, expected: Array, none: float | None = None) -> Array:
    """The parameters with the likeliest part of what is expected of a hypothesis; ``none``: -log L without any."""
    where = [bench.index[candidate.parameter(schema)] for schema in candidate.linear]

    def likeliest(parts: Sequence[float]) -> tuple[float, Array]:
        trials = [p.copy() for _ in parts]
        for part, trial in zip(parts, trials, strict=True):
            trial[where] += part * (expected - p[where])
        losses = [bench.filtered(trial).loss for trial in trials]
        best = int(np.argmin(losses))
        return losses[best], trials[best]

    loss, start = likeliest(PARTS)
    if not loss < (bench.filtered(p).loss if none is None else none):
        less, smaller = likeliest(SMALLER)
        loss, start = (less, smaller) if less < loss else (loss, start)
    return start if np.isfinite(loss) else p


def without_effect(model: Model, current: Explanation, item: tuple[Candidate, float | None]) -> Explanation:
    p, beliefs = at_null(model, current, item[0])
    rest = tuple(other for other in current.found if other is not item)
    return explained(model, rest, beliefs, fit(current.fit.bench, p, beliefs))


def at_null(model: Model, current: Explanation, candidate: Candidate) -> tuple[Array, Beliefs]:
    """All parameters, an effect's own where it vanishes; and what is believed of the others."""
    p, index = current.fit.p.copy(), current.fit.bench.index
    names = {candidate.parameter(s) for s in (*candidate.linear, *candidate.shapes)}
    for name in names:
        p[index[name]] = model.values[index[name]]
    return p, {name: belief for name, belief in current.beliefs.items() if name not in names}


def remembered(of: Explanation) -> tuple[Candidate, ...]:
    """What was found that has states of its own."""
    return tuple(c for c, _ in of.found if c.effect in MEMORIES)


def step(
    model: Model, current: Explanation, alarms: list[str], progress: Progress, rival: float = 0.0, doubt: bool = True
) -> tuple[Step | None, tuple[Step, ...]]:
    """The hypothesis that explains most of what is left, and all that were fitted; None where none earns its place.

    ``rival``: nats that something else is expected to gain; what promises far less is not fitted. Without ``doubt``
    that anything is left, only what promises its price is.
    """
    open_to_all = that_show(model, current, ready(model, current))
    ranked = scores(current.fit.bench, current.fit.p, tuple(current.beliefs), open_to_all, progress)
    worth = [WORTH + (0.0 if doubt else price(model, s.candidate)) for s in ranked]
    significant = [s for s, x in zip(ranked, worth, strict=True) if s.gain > x and s.p_value * len(ranked) < LEVEL]
    tried: tuple[Step, ...] = ()
    asked: list[Candidate] = []
    for _ in range(TURNS):
        open_ = [s for s in significant if s.candidate not in asked]
        least = PROMISING * max(rival, max((s.gain for s in open_), default=0.0))
        promising = [s for s in open_ if s.gain > least][:TRIED]
        if doubt:  # parameters may hide a delay, which no slope shows any more
            late_ones = [s for s in ranked if _absorbed(model, current, s.candidate)]
            promising += [s for s in late_ones if s not in promising and s.candidate not in asked]
        if not promising or (asked and not allowed("effects that promise less")):
            break
        asked += [s.candidate for s in promising]
        tried = (*tried, *fitted(model, current, promising, progress))
        best = that_earns(model, current, tried, alarms)
        if best is not None:
            return best, tried
    if not (doubt and covers(current)) or not allowed("effects that an unknown force does the work of"):
        return None, tried
    uncovered = _uncovered(current, [c for c in open_to_all if c not in asked], progress)
    tried = (*tried, *fitted(model, current, uncovered, progress))
    return that_earns(model, current, tried, alarms, covered=True), tried


def ready(model: Model, current: Explanation) -> list[Candidate]:
    """Hypotheses that are neither found nor part of the model, and whose base is there.

    A base may be anywhere on the joint's drive: what moves together rubs together, and a model has it where it was
    convenient.
    """
    there = [(c.effect, c.place.address) for c, _ in current.found] + [(e.type, e.at) for e in model.robot.effects]
    here = {(effect, at) for effect, place in there for at in same_place(model.robot, place)}
    drives = {(effect, joint_name(at)) for effect, at in here}
    return [
        c
        for c in model.proposed
        if (c.effect, c.place.address) not in here
        and (c.builds_on is None or (c.builds_on, joint_name(c.place.address)) in drives)
    ]


def covers(current: Explanation) -> bool:
    """Whether an unknown force does much of the work."""
    bench, p = current.fit.bench, current.fit.p
    return bench.with_noise(bench.noise.quiet).filtered(p).loss - bench.filtered(p).loss >= WORTH


def _uncovered(current: Explanation, hypotheses: Sequence[Candidate], progress: Progress) -> list[Score]:
    """What the unknown force does the work of: once it is fitted, a constant beside it gains next to nothing.

    So the hypotheses are asked without it. How much they tell then is their order, and no measure of certainty.
    """
    bench = current.fit.bench
    quiet = bench.with_noise(bench.noise.quiet)
    ranked = scores(quiet, current.fit.p, tuple(current.beliefs), hypotheses, progress)
    return likeliest_of(ranked)


def likeliest_of(ranked: Sequence[Score]) -> list[Score]:
    """Those worth a fit where a score is an order, and no measure of certainty."""
    least = max(WORTH, PROMISING * max((s.gain for s in ranked), default=0.0))
    return [s for s in ranked if s.gain > least][:TRIED]


def fitted(
    model: Model,
    current: Explanation,
    promising: Sequence[Score],
    progress: Progress,
    begin: Callable[[Score], MLFit] | None = None,
    end: Callable[[MLFit, Beliefs], MLFit] | None = None,
    least: float = math.inf,
) -> tuple[Step, ...]:
    """Each of them on top of an explanation; those that came near the likeliest, or were expected to, are fitted to
    the end and judged.

    ``begin`` fits one roughly, by default from where the explanation stands; ``end`` to the end. What ``begin`` leaves
    above a loss of ``least`` is given up.
    """
    if not promising:
        return ()

    def roughly(score: Score) -> MLFit:
        progress(f"fitting {score.candidate.label}")
        if begin is not None:
            return begin(score)
        return with_effect(model, current, score.candidate, score.shape, score.estimate)

    def closely(item: tuple[Score, MLFit]) -> Step:
        score, rough = item
        progress(f"fitting {score.candidate.label}, closer")
        beliefs = dict(current.beliefs) | candidate_beliefs(score.candidate, score.shape)
        found = (*current.found, (score.candidate, score.shape))
        done = end(rough, beliefs) if end is not None else fit(rough.bench, rough.p, beliefs)
        after = explained(model, found, beliefs, done)
        return Step(score, after, current.fit.loss - after.fit.loss, heldout_p_value(current, after))

    rough = list(zip(promising, side_by_side(roughly, promising), strict=True))
    worth = [current.fit.loss - found.loss - price(model, score.candidate) for score, found in rough]
    best, most = rough[int(np.argmax(worth))][0], max(worth)
    expected = max(score.gain for score in promising) - WORTH  # of what a rough fit alone may have put behind
    near = [
        (score, found)
        for (score, found), gained in zip(rough, worth, strict=True)
        if (gained >= most - (1.0 - LIKELY) * abs(most) or score.gain > expected or contains(best, score))
        and found.loss < least
    ]
    return tuple(side_by_side(closely, near))


def sampled(model: Model, current: Explanation) -> Explanation:
    """The same with inputs held over a step instead of straight, or the other way round, where that fits better.

    Either looks like half a step of delay to the other; so it is tried where a delay would gain something, where the
    circuit may have absorbed it, or where the other is likelier as it is: with an unknown force beside it, a delay
    gains nothing. A delay that was found is moved by that half step. Band-limited ones are nearly straight, and tried
    in their place where one round makes them likelier.
    """
    late = [c for c in model.proposed if c.effect in DELAYS]
    bench = current.fit.bench
    suspects = set(absorbing(current)) & model.electrical
    other_way = bench.with_inputs(bench.between.other)
    p = the_other_way(other_way, current.fit.p, bench.between)
    likelier = other_way.filtered(p).loss < bench.filtered(current.fit.p).loss
    ways = [] if bench.between is Between.HELD else [x for x in bench.ways if x not in (bench.between, Between.HELD)]
    tried = [fit(bench.with_inputs(way), current.fit.p, current.beliefs, most=1) for way in ways]
    starts = [(each.bench, each.p) for each in tried if each.loss < current.fit.loss - WORTH]
    found = [] if likelier or suspects else scores(bench, current.fit.p, tuple(current.beliefs), late)
    if likelier or suspects or (found and found[0].gain >= WORTH):
        starts.append((other_way, p))
    if suspects:
        starts.append((other_way, put_back(current, p)))
    if not starts:
        return current
    fits = side_by_side(lambda start: fit(*start, current.beliefs, most=ROUNDS), starts)
    other = min(fits, key=lambda fitted: fitted.loss)
    if other.loss > current.fit.loss:
        return current
    return explained(model, current.found, current.beliefs, fit(other.bench, other.p, current.beliefs))
