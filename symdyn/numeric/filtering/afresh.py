"""Fits that begin once more with the model as given: parameters and noise may have gone where none leads back from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.beliefs import Beliefs
from symdyn.numeric.filtering.bench import FilterBench, Noise
from symdyn.numeric.filtering.budget import allowed
from symdyn.numeric.filtering.explain import (
    ROUGH,
    ROUNDS,
    TRIED,
    Progress,
    begun,
    fitted,
    likeliest_of,
    ready,
    shaped,
)
from symdyn.numeric.filtering.graduated import graduated
from symdyn.numeric.filtering.judged import (
    WORTH,
    Explanation,
    Step,
    explained,
    floor,
    heldout_p_value,
    improves,
    price,
    tells_all,
    that_earns,
)
from symdyn.numeric.filtering.late import absorbing, the_other_way
from symdyn.numeric.filtering.likelihood import MLFit, fit
from symdyn.numeric.filtering.model import Model, as_it_begins, candidate_beliefs, joined
from symdyn.numeric.filtering.score import Score, scores
from symdyn.numeric.filtering.side_by_side import side_by_side
from symdyn.numeric.filtering.stiff import that_show
from symdyn.numeric.filtering.windows import NEGLIGIBLE, SHARE, beyond

Array = NDArray[np.float64]

TWICE = 0.75  # of an error's power beyond noise: it is twice as large as that
LITTLE = (1e-2, 1e-9)  # of the power of an unknown force: how it may be let in again


def relieved(model: Model, current: Explanation, progress: Progress) -> Explanation | None:
    """A likelier fit with the same effects, begun once more from the model as given; None where there is none.

    A fit without what is missing may carry parameters where none leads back from (a motor's inertia to next to
    nothing), and may find inputs held between samples that go straight, or the other way round. Asked for only where
    some went far, or free runs are off by more than the sensors' noise.
    """
    far = off(model, current)
    if not (absorbing(current) or far) or not allowed("whether a fit from the model as given is likelier"):
        return None
    progress("once more from the model as given")
    bench, p = as_given(model, current)
    quiet, beliefs = bench.with_noise(bench.noise.quiet), current.beliefs
    starts = [(quiet, p)]
    if far:
        clear, near = graduated(model, bench, p, beliefs)
        other = clear.with_inputs(bench.between.other)
        starts += [(clear, near), (other, the_other_way(other, near, bench.between))]

    def without_force() -> MLFit:
        return let_in(current.fit.bench.noise, likeliest(starts, beliefs), beliefs)

    ways = side_by_side(lambda way: way(), (lambda: fit(bench, p, beliefs), without_force))
    again = min(ways, key=lambda each: each.loss)
    if again.loss > current.fit.loss - WORTH:
        return None
    return explained(model, current.found, beliefs, again)


def astray(model: Model, current: Explanation) -> bool:
    """Whether free runs are off by twice the sensors' noise: what was fitted before an effect was found may be far off.

    The next effect would be one that makes up for it.
    """
    return off(model, current, TWICE)


def unburdened(
    model: Model, current: Explanation, best: Step | None, tried: Sequence[Step], alarms: list[str]
) -> tuple[Step | None, tuple[Step, ...]]:
    """The likeliest step, and all that were tried, fitted on without the unknown force, which is let in again.

    A force that did an effect's work does not let go of it by small steps, and bends parameters beside it (an arm's
    inertia by a tenth, 15 000 nats from where dry friction alone tells all). What was behind ``best`` by less than
    that brought, the same law at a neighbour's among it, is asked as well: only what was fitted alike can be compared.
    So is what has fewer numbers at the same place, and free runs as good: a force must hide what it is behind by. Where
    nothing earned its place beside such a force, the likeliest of what was worth its price begins.
    """
    worth = [s for s in tried if s.gain > WORTH + price(model, s.score.candidate)]
    first = best or min(worth, key=lambda s: s.after.fit.loss, default=None)
    let_go = _let_go(model, current, first) if first else None
    if first is None or let_go is None:
        return best, tuple(tried)
    brought = first.after.fit.loss - let_go.after.fit.loss
    far = first.after.fit.loss + brought if let_go is not first else -np.inf
    behind = [s for s in worth if s is not first and (s.after.fit.loss < far or _as_good(first, s))]
    if let_go is first and not behind:
        return best, tuple(tried)
    near = sorted(behind, key=lambda s: s.after.fit.loss)[:TRIED]
    others = side_by_side(lambda s: _let_go(model, current, s), near)
    alike = dict(zip([first, *near], [let_go, *others], strict=True))
    chosen = that_earns(model, current, tuple(alike.values()), alarms) or (let_go if best else None)
    return chosen, tuple(alike.get(s, s) for s in tried)


def _as_good(wide: Step, less: Step) -> bool:
    """Whether a smaller effect at the same place is less likely, and free runs do not tell why."""
    one, other = wide.score.candidate, less.score.candidate
    return (
        one.place == other.place
        and one.size > other.size
        and less.after.fit.loss > wide.after.fit.loss + WORTH
        and not improves(less.after, wide.after)
    )


def _let_go(model: Model, current: Explanation, step: Step) -> Step:
    """The step without the unknown force, which is let in again if something is left; as it was, if likelier."""
    after = step.after
    bench, beliefs = after.fit.bench, after.fit.beliefs
    if len(bench.noise.power) == bench.noise.inputs:
        return step
    quiet = fit(bench.with_noise(bench.noise.quiet), after.fit.p, beliefs, settled=ROUGH, most=ROUNDS)
    if quiet.loss > after.fit.loss - WORTH:
        return step
    again = explained(model, after.found, beliefs, fit(quiet.bench, quiet.p, beliefs))
    if not tells_all(model, again):
        again = explained(model, after.found, beliefs, let_in(bench.noise, quiet, beliefs))
    gain = step.gain + after.fit.loss - again.fit.loss
    return replace(step, after=again, gain=gain, p_value=heldout_p_value(current, again))


def afresh(
    model: Model, current: Explanation, alarms: list[str], progress: Progress
) -> tuple[Step | None, tuple[Step, ...]]:
    """The hypothesis that explains most on top of the model as given, and all that were fitted.

    What a machine lacks may be made up for so well, by inertias and by unknown forces, that no hypothesis gains
    anything any more. So they are asked where nothing has been made up yet: the given parameters, those of the effects
    found, and no unknown force. Only where free runs are off by more than the sensors' noise; and what gets no nearer
    there in a few rounds than the explanation does without its unknown force is given up.
    """
    if not off(model, current) or not allowed("what explains most on top of the model as given"):
        return None, ()
    progress("every hypothesis on the model as given")
    bench, p = as_given(model, current)
    bench, beliefs = bench.with_noise(bench.noise.quiet), current.beliefs
    ranked = scores(bench, p, tuple(beliefs), that_show(model, current, ready(model, current)), progress)
    promising = likeliest_of(ranked)
    none = bench.filtered(p).loss

    def begin(score: Score) -> MLFit:
        start = shaped(bench, p, score.candidate, score.shape)
        names = dict(beliefs) | candidate_beliefs(score.candidate, score.shape)
        first = begun(bench, start, score.candidate, score.estimate, none)
        return fit(bench, first, names, settled=ROUGH, most=ROUNDS)

    def end(rough: MLFit, names: Beliefs) -> MLFit:
        return let_in(current.fit.bench.noise, fit(rough.bench, rough.p, names), names)

    now = current.fit.bench
    without = now.with_noise(now.noise.quiet).filtered(current.fit.p).loss
    tried = fitted(model, current, promising, progress, begin, end, least=without)
    return that_earns(model, current, tried, alarms), tried


def two_afresh(
    model: Model, current: Explanation, tried: Sequence[Step], progress: Progress
) -> tuple[Step, Step] | None:
    """Two effects that explain more on top of the model as given than an unknown force does, where neither alone does.

    A force does the work of both: beside an amplifier's offset, say, that of its dead zone. ``tried`` are those that
    were fitted there (``afresh``), the likeliest of which gets another one beside it.
    """
    first = min(tried, key=lambda s: s.after.fit.loss, default=None)
    if first is None:
        return None
    second, _ = afresh(model, first.after, [], progress)
    if second is None:
        return None
    least = WORTH + price(model, first.score.candidate) + price(model, second.score.candidate)
    gain = current.fit.loss - second.after.fit.loss
    return (first, second) if gain > least and improves(current, second.after) else None


def off(model: Model, current: Explanation, share: float = SHARE) -> bool:
    """Whether free runs, held out, are off by more than the noise of the sensors, and by anything to speak of."""
    return current.heldout > NEGLIGIBLE and beyond(current.heldout, floor(model, current)) > share


def as_given(model: Model, current: Explanation) -> tuple[FilterBench, Array]:
    """Filter and parameters of the model as given, with what was found."""
    p, bench = current.fit.p.copy(), current.fit.bench
    for name in model.beliefs:
        p[bench.index[name]] = model.values[bench.index[name]]
    return as_it_begins(model, bench), p


def let_in(unknown: Noise, of: MLFit, beliefs: Beliefs) -> MLFit:
    """The fit with those unknown forces again, which shall tell whether something is left."""
    little = (replace(unknown, power=part * unknown.power) for part in LITTLE)
    return likeliest([(of.bench.with_noise(joined(of.bench.noise, each)), of.p) for each in little], beliefs)


def likeliest(starts: Sequence[tuple[FilterBench, Array]], beliefs: Beliefs) -> MLFit:
    """The likeliest after a few rounds of those that begin there, fitted to the end."""
    rough = side_by_side(lambda start: fit(*start, beliefs, settled=ROUGH, most=ROUNDS), starts)
    best = min(rough, key=lambda each: each.loss)
    return fit(best.bench, best.p, beliefs)
