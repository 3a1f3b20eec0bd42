"""An explanation where part of the machine is hidden, judged on held-out data: whether an effect earns its place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from symdyn.numeric.candidates import Candidate
from symdyn.numeric.filtering.beliefs import Beliefs
from symdyn.numeric.filtering.likelihood import MLFit
from symdyn.numeric.filtering.locate import certainly_apart
from symdyn.numeric.filtering.model import Model
from symdyn.numeric.filtering.score import Score
from symdyn.numeric.filtering.windows import free_runs, noise_alone, off, overall, relative_errors
from symdyn.numeric.regression import encompassing, long_run_covariance
from symdyn.physics import catalogue

Array = NDArray[np.float64]
Found = tuple[tuple[Candidate, float | None], ...]

LEVEL = 0.01  # significance of a gain
WORTH = 10.0  # nats that an effect must bring on training data, beside half the logarithm of N per number (BIC)
ABOUT = 0.1  # of the free-run error, held out: explanations that differ less may be alike
EARNS = 0.03  # of the free-run error, held out: less is not worth a line in a model
LIKELY = 0.7  # of the best gain: what has less is far behind
CERTAIN = float(stats.norm.isf(LEVEL / 2.0))


@dataclass(frozen=True, slots=True, eq=False)
class Explanation:
    """``found`` on top of the model as given, all parameters and the noise fitted on training data."""

    found: Found
    beliefs: Beliefs
    fit: MLFit
    score: Array  # (N,) log-likelihood of each held-out sample
    errors: tuple[Array, Array]  # (m + t,) free-run errors of channels and twists: training, held out
    predicted: Array  # (N, m) held-out free runs
    off: Array  # (N, m + t) their errors, relative to how far each channel moves

    @property
    def heldout(self) -> float:
        return overall(self.errors[1])


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One hypothesis, fitted in full on top of an explanation. ``gain`` in nats on training data."""

    score: Score
    after: Explanation
    gain: float
    p_value: float  # of no gain on held-out data
    group: tuple[str, ...] = ()  # places that are not told apart, as far as that is known already


def explained(model: Model, found: Found, beliefs: Beliefs, fitted: MLFit) -> Explanation:
    """Judge a fit: its likelihood and its free runs on held-out data."""
    judge = model.bench(model.heldout, fitted.bench.noise, fitted.bench.between)
    done = judge.filtered(fitted.p)
    score = -0.5 * np.sum(done.white**2 + np.log(done.variances), axis=1)
    predicted = free_runs(judge, fitted.p)
    training = relative_errors(fitted.bench, free_runs(fitted.bench, fitted.p))
    errors = training, relative_errors(judge, predicted)
    return Explanation(found, beliefs, fitted, score, errors, predicted, off(judge.signals, predicted))


def that_earns(
    model: Model, current: Explanation, tried: Sequence[Step], alarms: list[str], covered: bool = False
) -> Step | None:
    """The likeliest of them that earns its place: by likelihood, by certainty of its size, and on held-out data.

    ``covered``: an unknown force does its work, and the likelihood hardly rises; free runs, which have no such force,
    decide.
    """
    if covered:
        order = sorted(tried, key=lambda s: s.after.heldout)
    else:
        order = sorted(tried, key=lambda s: s.after.fit.loss + price(model, s.score.candidate))
    for each in [simplest(model, wide, order) for wide in order]:
        label = each.score.candidate.label
        if each.gain < (0.0 if covered else WORTH + price(model, each.score.candidate)):
            continue
        shortfall = _shortfall(model, current, each.after, each.score.candidate, each.p_value)
        if not shortfall:
            return each
        alarms.append(f"{label} {shortfall}")
    return None


def floor(model: Model, of: Explanation) -> float:
    """What the sensors' noise alone would leave of the held-out free-run error."""
    return overall(noise_alone(model.heldout, of.fit.bench.noise.r))


def nothing_left(model: Model, of: Explanation) -> bool:
    """Whether free runs, held out, are off by hardly more than the noise of the sensors."""
    return of.heldout < (1.0 + ABOUT) * floor(model, of)


def tells_all(model: Model, current: Explanation) -> bool:
    """Whether free runs, held out, are off by so little that sensors' noise leaves no effect room to earn its place."""
    return (1.0 - EARNS) * current.heldout < floor(model, current)


def contains(wide: Score, less: Score) -> bool:
    """Whether one law is a special case of another at the same place, or nearly.

    What corrects a law is asked beside it only where that is elsewhere on the drive (``ready``): at its own place it
    is then that law, where the correction reaches as far as the motion does.
    """
    one, other = wide.candidate, less.candidate
    law = catalogue()[one.effect]
    corrected = law.builds_on == other.effect and one.size > other.size
    return one.place == other.place and (other.effect in law.generalises or corrected)


def simplest(model: Model, wide: Step, tried: Sequence[Step]) -> Step:
    """A law that this one contains, at the same place, unless what this one adds earns its place like any effect.

    Where the wider leaves free runs nothing more to tell, the likelihood decides.
    """
    less = [
        s
        for s in tried
        if contains(wide.score, s.score) and not improves(s.after, wide.after) and not _far_behind(model, s, wide)
    ]
    return min(less, key=lambda s: s.score.candidate.size, default=wide)


def _far_behind(model: Model, less: Step, wide: Step) -> bool:
    """Whether a law is not nearly as likely, on held-out data too, as one that leaves only the sensors' noise."""
    return (
        tells_all(model, wide.after)
        and worth(model, less) < LIKELY * worth(model, wide)
        and likelihood_p_value(less.after, wide.after) < LEVEL
    )


def earns(model: Model, before: Explanation, after: Explanation, candidate: Candidate) -> bool:
    """Whether an effect is worth a line in the model: certain in its size, and better on held-out data."""
    return not _shortfall(model, before, after, candidate, heldout_p_value(before, after))


def _shortfall(model: Model, before: Explanation, after: Explanation, candidate: Candidate, p_value: float) -> str:
    """What an effect lacks that would earn it a line in the model; nothing, if it earns one."""
    if not certain(model, after, candidate):
        return "raises the likelihood, but its size cannot be told from zero"
    if not improves(before, after, p_value):
        return "fits the training data better, but not the held-out data"
    return ""


def improves(before: Explanation, after: Explanation, p_value: float | None = None) -> bool:
    """Whether held-out data tell the two apart, and free runs are better by enough to matter."""
    told = heldout_p_value(before, after) if p_value is None else p_value
    return told < LEVEL and after.heldout <= (1.0 - EARNS) * before.heldout


def certain(model: Model, after: Explanation, candidate: Candidate) -> bool:
    """Whether any of its parameters can be told from the value at which it vanishes."""
    if not candidate.linear:
        return True
    names = after.fit.names
    for schema in candidate.linear:
        i = names.index(candidate.parameter(schema))
        value, se = after.fit.p[after.fit.bench.index[names[i]]], float(np.sqrt(after.fit.covariance[i, i]))
        if abs(value - (schema.null or 0.0)) > CERTAIN * se:
            return True
    return False


def alike(chosen: Step, tried: Sequence[Step]) -> tuple[Step, ...]:
    """Hypotheses with no more numbers that held-out data do not tell from the chosen one."""
    return tuple(
        s
        for s in tried
        if s is not chosen
        and s.score.candidate.size <= chosen.score.candidate.size
        and s.after.heldout < (1.0 + ABOUT) * chosen.after.heldout
        and not certainly_apart(s.after.score, chosen.after.score)
    )


def worth(model: Model, of: Step) -> float:
    """Nats beyond its price."""
    return of.gain - price(model, of.score.candidate)


def price(model: Model, candidate: Candidate) -> float:
    """In nats: half the logarithm of the number of samples for each number (BIC)."""
    return price_of(model, candidate.size)


def price_of(model: Model, numbers: int) -> float:
    """The same for so many numbers."""
    return 0.5 * numbers * float(np.log(len(model.training.y)))


def heldout_p_value(before: Explanation, after: Explanation) -> float:
    """One-sided, of no gain on held-out data: in likelihood, or in free runs, which no unknown force helps along.

    The smaller of the two, doubled; samples that are correlated are allowed for in both.
    """
    likelihood = likelihood_p_value(before, after)
    whole = np.all(np.isfinite(before.off) & np.isfinite(after.off), axis=1)
    gain, running = encompassing(before.off[whole], after.off[whole])
    return min(1.0, 2.0 * min(likelihood, running if gain > 0 else 1.0))


def likelihood_p_value(before: Explanation, after: Explanation) -> float:
    """p-value, one-sided, of no gain in held-out likelihood."""
    difference = after.score - before.score
    if not np.all(np.isfinite(difference)):
        return 1.0
    spread = float(np.sqrt(max(long_run_covariance(difference[:, None])[0, 0], 0.0) / len(difference)))
    return float(stats.norm.sf(float(np.mean(difference)) / max(spread, 1e-300)))
