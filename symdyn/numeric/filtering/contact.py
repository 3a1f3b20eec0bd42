"""Play between two parts: a fit that begins without any finds none, and what it bends instead hides it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.afresh import TWICE, as_given, let_in, off
from symdyn.numeric.filtering.beliefs import Beliefs
from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.budget import allowed
from symdyn.numeric.filtering.explain import ROUGH, ROUNDS, Progress, fitted, ready
from symdyn.numeric.filtering.graduated import graduated
from symdyn.numeric.filtering.judged import LIKELY, Explanation, Step, that_earns
from symdyn.numeric.filtering.likelihood import MLFit, fit
from symdyn.numeric.filtering.locate import brief
from symdyn.numeric.filtering.model import Model, candidate_beliefs
from symdyn.numeric.filtering.score import Score, scores
from symdyn.numeric.filtering.side_by_side import side_by_side
from symdyn.physics import with_play

Array = NDArray[np.float64]

PART = 0.3  # of how far a shaft twists in the model as given: the clearance that fits begin with


def loosened(
    model: Model, current: Explanation, best: Step | None, tried: Sequence[Step], alarms: list[str], progress: Progress
) -> tuple[Step | None, tuple[Step, ...]]:
    """The likeliest of ``best`` and of the plays that the machine may have, and all that were fitted.

    Only where free runs are off by twice the sensors' noise with the best of all else, or by more than that noise where
    nothing else is found. Each fit begins with the model as given, with some play, and with forces of which nothing is
    known, so that flanks may meet when they do. Of several plays those go on that a stretch of the recording finds
    about as likely as the likeliest, and of these what comes near ``current``, which has an unknown force beside it;
    what is hardly likelier than the same without play is none.
    """
    plays = [c for c in ready(model, current) if c.effect in with_play()]
    if not plays or not (off(model, best.after, TWICE) if best else off(model, current)):
        return best, tuple(tried)
    bench, given = as_given(model, current)
    quiet, beliefs = bench.with_noise(bench.noise.quiet), current.beliefs
    twists = _twists(model, quiet, given)
    known = [
        s for s in scores(quiet, given, tuple(beliefs), plays, progress) if twists[s.candidate.place.address] > 0.0
    ]
    if not known or not allowed(f"play at {' and '.join(s.candidate.place.address for s in known)}"):
        return best, tuple(tried)

    part = brief(model)  # tells where a fit may begin, in a third of the time or less, and which play is likely
    short = part.bench(part.training, quiet.noise, quiet.between)

    def on_a_stretch(start: Array, names: Beliefs) -> MLFit:
        ways = (graduated(part, short.with_inputs(way), start, names) for way in (quiet.between, quiet.between.other))
        return min((fit(*way, names, settled=ROUGH, most=ROUNDS) for way in ways), key=lambda each: each.loss)

    def on_all(brief: MLFit) -> MLFit:
        bench = model.bench(model.training, brief.bench.noise, brief.bench.between)
        return fit(bench, brief.p, brief.beliefs, settled=ROUGH, most=ROUNDS)

    def with_some(score: Score) -> tuple[Array, Beliefs]:
        start = given.copy()
        (clearance,) = score.candidate.linear
        start[bench.index[score.candidate.parameter(clearance)]] = PART * twists[score.candidate.place.address]
        return start, dict(beliefs) | candidate_beliefs(score.candidate, None)

    def end(rough: MLFit, names: Beliefs) -> MLFit:
        return let_in(current.fit.bench.noise, fit(rough.bench, rough.p, names), names)

    progress(f"some play at {' and '.join(s.candidate.place.address for s in known)}")
    starts = [(given, beliefs), *map(with_some, known)]
    tight, *loose = side_by_side(lambda start: on_a_stretch(*start), starts)
    gains = [tight.loss - each.loss for each in loose]
    least = max(gains) - (1.0 - LIKELY) * abs(max(gains))
    begun = {_key(s): each for s, each, gain in zip(known, loose, gains, strict=True) if gain >= least}
    likely = [s for s in known if _key(s) in begun]
    tight = on_all(tight)
    near = tight.loss - LIKELY * max(0.0, tight.loss - current.fit.loss)
    found = fitted(model, current, likely, progress, lambda s: on_all(begun[_key(s)]), end, least=near)
    whole = (*tried, *(each for each in found if each.gain > (best.gain if best else 0.0)))
    return (that_earns(model, current, whole, alarms) or best) if len(whole) > len(tried) else best, whole


def _key(play: Score) -> tuple[str, str]:
    return play.candidate.effect, play.candidate.place.address


def _twists(model: Model, bench: FilterBench, p: Array) -> dict[str, float]:
    """How far two parts go from each other, by the address of what couples them."""
    q = bench.filtered(p).states[:, : len(model.kernel.coordinates)]
    return {latent.place: float(np.std(q @ latent.motion)) for latent in model.latents}
