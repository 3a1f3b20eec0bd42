"""Evidence in nats: by how much one explanation makes data more likely that neither was fitted to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.regression import long_run_covariance

Array = NDArray[np.float64]

TINY = 1e-300


def gaussian_gain(before: Array, after: Array, independent: float) -> float:
    """Gain of the log-likelihood, errors (K, n) taken for Gaussian noise of unknown size at each joint.

    Half the number of independent samples times the fall of the log of the mean square. Samples
    that are correlated say one thing together: their number is that of ``after`` by its long-run
    variance, and at most ``independent``, what the band can hold.
    """
    total = 0.0
    for j in range(before.shape[1]):
        old, new = (float(np.mean(r[:, j] ** 2)) for r in (before, after))
        total += 0.5 * effective_count(after[:, j], independent) * float(np.log(max(old, TINY) / max(new, TINY)))
    return total


def effective_count(residual: Array, independent: float) -> float:
    """How many independent samples (K,) correlated ones are worth."""
    power = float(np.var(residual))
    if power == 0.0:
        return independent
    inflation = float(long_run_covariance(residual[:, None])[0, 0]) / power
    return min(independent, len(residual) / max(inflation, 1.0))


def coloured_gain(training: Array, heldout: Array, per_band: float) -> float:
    """Gain of the Whittle log-likelihood of ``heldout`` (K,) by a latent force instead of white noise.

    The latent force has the spectrum that ``training`` shows, falling with frequency (noise that was
    differentiated rises, and is no force); white noise has its mean level. Each Fourier frequency in
    the band is one complex Gaussian number, so that correlated samples are counted for what they hold.
    ``per_band`` samples per period of the band's edge.
    """
    learnt, seen = _periodogram(training, per_band), _periodogram(heldout, per_band)
    if len(learnt) < 8 or len(seen) < 8 or not learnt.any() or not seen.any():
        return 0.0
    level = np.full(len(seen), learnt.mean())
    falling = _falling(learnt)
    at = (np.arange(len(seen)) + 0.5) / len(seen) * len(learnt) - 0.5
    shape = np.interp(at, np.arange(len(learnt)), falling)
    scale_level, scale_shape = float(np.mean(seen / level)), float(np.mean(seen / shape))
    # Each with the size that suits the held-out data best: evidence is about shape, not about loudness.
    return float(np.sum(np.log(level * scale_level) - np.log(shape * scale_shape)))


def _periodogram(residual: Array, per_band: float) -> Array:
    """Power at the Fourier frequencies inside the band."""
    power = np.abs(np.fft.rfft(residual - residual.mean())) ** 2
    edge = int(len(residual) / per_band * 0.9)
    return np.asarray(power[1 : max(edge, 1)])


def _falling(power: Array) -> Array:
    """Least-squares fit that never rises (pool adjacent violators), on bins of equal width, at least a floor."""
    bins = min(64, len(power) // 4)
    parts = np.array_split(power, bins)
    means, weights, counts = [], [], []
    for part in parts:
        means.append(float(part.mean()))
        weights.append(float(len(part)))
        counts.append(1)
        while len(means) > 1 and means[-2] < means[-1]:
            weight = weights[-2] + weights[-1]
            means[-2] = (means[-2] * weights[-2] + means[-1] * weights[-1]) / weight
            weights[-2], counts[-2] = weight, counts[-2] + counts[-1]
            del means[-1], weights[-1], counts[-1]
    pooled = np.repeat(means, counts)
    fitted = np.concatenate([np.full(len(part), value) for part, value in zip(parts, pooled, strict=True)])
    return np.asarray(np.maximum(fitted, 1e-6 * power.mean() + TINY))
