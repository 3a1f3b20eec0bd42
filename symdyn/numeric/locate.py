"""Where the model as given does not account for the recording, and when: joint by joint, against held-out data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from symdyn.numeric.conditions import Condition, conditions
from symdyn.numeric.evidence import coloured_gain, gaussian_gain
from symdyn.numeric.findings import Finding, Located
from symdyn.numeric.free_form import Fitted, FreeForm
from symdyn.numeric.leftover import SLOW_SHARE, slow_share
from symdyn.numeric.noise_floor import independent_samples
from symdyn.numeric.regression import encompassing
from symdyn.numeric.workbench import Workbench

Array = NDArray[np.float64]

LEVEL = 0.01
SHARE = 0.05  # of the power at a joint that a condition must tell to be named
SIMPLER = 0.8  # of the best gain: with that much, the condition of the fewest cells is taken
MOST = 4  # conditions told per place
NARROW = 1.5  # ratio of two frequencies between which most of a power lies, below which it is one line


@dataclass(frozen=True, slots=True, eq=False)
class Left:
    """Weighted residuals while conditions are taken out: (K, n) on training and on held-out data."""

    training: Array
    heldout: Array

    def power(self, j: int) -> float:
        """Mean square at a joint on held-out data."""
        return max(float(np.mean(self.heldout[:, j] ** 2)), 1e-300)


def located(
    bench: Workbench, judge: Workbench, fitted: Fitted, residuals: Left, groups: Sequence[Sequence[str]]
) -> tuple[Located, ...]:
    """Joints with structure in their residual, best evidence first.

    ``fitted`` is the model as given, ``residuals`` are its own, ``groups`` the places that move rigidly
    with each joint. For each joint the ``conditions`` are tried as free-form forces on top of the
    model, which is refitted with each: learnt on training data (cross-validated there; of the good
    ones the simplest is taken), held against the held-out data at a significance of 1 % over all
    joints and conditions tried. What a condition tells is taken out before the next. Structure that
    follows no condition, but is slow where noise would be even, is told by its frequencies.
    """
    form = FreeForm(fitted)
    joints = fitted.joints
    count = independent_samples(judge)
    counts = fitted.weight > 0.0
    unweighted = np.divide(1.0, fitted.weight, out=np.zeros_like(fitted.weight), where=counts)
    loads = bench.effort - residuals.training * unweighted, judge.effort - residuals.heldout * unweighted
    found = []
    for j, joint in ((j, joint) for j, joint in enumerate(joints) if counts[j]):
        tried = conditions(bench, judge, joints, j, loads, residuals.training[:, j])
        left, when = _follow(form, residuals, tried, j, LEVEL / len(joints))
        gain = gaussian_gain(residuals.heldout, left.heldout, count) if when else 0.0
        share, p_value = slow_share(left.heldout[:, [j]], judge.samples_per_period)
        slow = share * left.power(j) > SHARE * residuals.power(j)
        if share > SLOW_SHARE and slow and p_value * len(joints) < LEVEL:
            when.append(_frequencies(left.heldout[:, j], judge))
        if when:
            latent = coloured_gain(residuals.training[:, j], residuals.heldout[:, j], judge.samples_per_period)
            found.append(Located(joint, tuple(groups[j]), max(gain, latent), tuple(when)))
    return tuple(sorted((f for f in found if f.evidence > 0.0), key=lambda f: -f.evidence))


def with_found(places: tuple[Located, ...], findings: Sequence[Finding]) -> tuple[Located, ...]:
    """With the places at which an effect was found though no condition told of it, such as in a few coarse samples."""
    known = {place for at in places for place in (at.place, *at.group)}
    new = []
    for found in findings:
        if found.evidence > 0.0 and not known & {found.place, *found.group}:
            known |= {found.place, *found.group}
            new.append(Located(found.place, found.group, found.evidence))
    return tuple(sorted((*places, *new), key=lambda at: -at.evidence))


def _follow(form: FreeForm, left: Left, tried: Sequence[Condition], j: int, level: float) -> tuple[Left, list[str]]:
    """Conditions that the residual at joint ``j`` follows, one after the other, and what they leave of it."""
    power = left.power(j)
    columns = [form.columns(condition, j) for condition in tried]
    when: list[str] = []
    while len(when) < MOST:
        gains = np.array([column.cross_validated_gain(left.training) for column in columns])
        if gains.max() <= 0.0:
            break
        good = [i for i in range(len(tried)) if gains[i] >= SIMPLER * gains.max()]
        best = min(good, key=lambda i: (tried[i].cells, -gains[i]))
        after = Left(*columns[best].taken_out(left.training, left.heldout))
        gain, p_value = encompassing(left.heldout, after.heldout)
        told = (left.power(j) - after.power(j)) / power
        if gain <= 0.0 or told < SHARE or p_value * MOST * len(tried) > level or tried[best].name in when:
            break
        when.append(tried[best].name)
        left = after
    return left, when


def _frequencies(residual: Array, judge: Workbench) -> str:
    """Between which frequencies most of the power lies: "about 1.3 Hz", "below 3 Hz", "2 to 5 Hz"."""
    rate = judge.observation.rate / (judge.band.stride if judge.band else 1)
    frequency, power = signal.periodogram(residual, rate, window="hann", detrend="constant")
    share = np.cumsum(power) / max(float(power.sum()), 1e-300)
    low, high = (float(frequency[np.searchsorted(share, part)]) for part in (0.1, 0.9))
    if high <= NARROW * low:
        return f"about {0.5 * (low + high):.2g} Hz"
    return f"below {high:.2g} Hz" if low < 0.2 * high else f"{low:.2g} to {high:.2g} Hz"
