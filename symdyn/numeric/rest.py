"""Where a joint's equation says nothing about the model: while it stands, and where it turns faster than was seen."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from symdyn.numeric.observation import Observation
from symdyn.numeric.position_noise import speed_noise

Array = NDArray[np.float64]

REST = 3.0  # standard deviations of a speed's own noise: a slower joint has no direction that could be told
WELL = 0.1  # of the root mean square of a speed: a slower one hides little of the motion
TOUCHED = 0.002  # weight of standing samples in the analysis band's filter from which a sample counts as standing
MOSTLY = 0.5  # of the samples count, at least
LITTLE = 0.05  # the same weight, of those that hold least of a standstill, up to which the others are left out for them

Marked = NDArray[np.bool_]
Bring = Callable[[Array], Array]  # (N, n) to (K, n): into the analysis band


def resting(observation: Observation) -> Marked:
    """(N, n) where no direction of motion can be told.

    What a joint does while it turns back is quicker than a motion that was smoothed below its encoder's steps: there
    it would hardly stand. That is seen before it was smoothed, where noise hides but slow motion.
    """
    o = observation
    slow = np.abs(o.qd) < REST * speed_noise(o)
    if o.quick is None:
        return np.asarray(slow)
    noise = REST * speed_noise(o, np.full(o.q.shape[1], o.cutoff))
    seen = noise < WELL * np.sqrt(np.mean(o.quick**2, axis=0))
    return np.asarray(np.where(seen, np.abs(o.quick) < noise, slow))


def touched(observation: Observation, bring: Bring) -> Marked:
    """(K, n) samples in the analysis band that hold some of those."""
    return np.asarray(_held(resting(observation), bring) > TOUCHED)


def _held(marked: Marked, bring: Bring) -> Array:
    """(K, n) how much of marked samples those in the analysis band hold."""
    return np.abs(bring(marked.astype(float)))


def standing(observation: Observation, bring: Bring, turns: Marked) -> Marked:
    """(K, n) samples in the analysis band that tell nothing of a joint's equation: it stands there, or ``turns``.

    Where that would be most of a joint's samples, all of them are taken as they are; or, ``sparing``, half of them,
    those that hold least of a standstill, where that is next to nothing.
    """
    weight = _held(resting(observation), bring)
    often = _often(weight) & observation.sparing
    rests = weight > np.where(often, np.quantile(weight, MOSTLY, axis=0), TOUCHED)
    out = rests | turns
    return np.asarray(np.where(np.mean(out, axis=0) > MOSTLY, rests & often, out))


def often_stands(observation: Observation, bring: Bring) -> bool:
    """Whether a joint is never far from a standstill in the band's filter, and yet hardly stands."""
    return bool(np.any(_often(_held(resting(observation), bring))))


def _often(weight: Array) -> Marked:
    mostly = np.mean(weight > TOUCHED, axis=0) > MOSTLY
    return np.asarray(mostly & (np.quantile(weight, MOSTLY, axis=0) <= LITTLE))


def turning(observation: Observation, edge: float | None, bring: Bring) -> Marked:
    """(K, n) samples around a reversal, in a band of which the ``edge`` (Hz) lies above that of the motion.

    Dry friction jumps there, and the acceleration with it. The effort shows the jump as it is, the motion shows it
    smoothed: for half a period of its edge to either side the two do not go together, whatever the model.
    """
    o = observation
    near = np.zeros(o.qd.shape, dtype=bool)
    for j, motion in enumerate(o.motions):
        if edge is None or edge <= motion:
            continue
        reach = int(np.ceil(0.5 * o.rate / motion))
        for part in o.segments:
            speed = o.qd[part, j]
            turns = np.diff(np.sign(speed), prepend=np.sign(speed[:1])) != 0
            near[part, j] = ndimage.maximum_filter1d(turns, 2 * reach + 1)
    return np.asarray(bring(near.astype(float)) > TOUCHED)
