"""Weighted linear least squares with standard errors that hold for correlated residuals."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft, optimize, stats

from symdyn.numeric.decomposition import least_squares, svd

Array = NDArray[np.float64]

BLOCK = 512  # rows
RANK_TOLERANCE = 1e-6  # of the largest singular value of columns scaled to unit length


@dataclass(frozen=True, slots=True, eq=False)
class LinearFit:
    """``estimate`` (k,), ``covariance`` (k, k); ``identifiable`` (k,) is False where data do not tell it."""

    estimate: Array
    covariance: Array
    identifiable: NDArray[np.bool_]

    @property
    def standard_error(self) -> Array:
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))  # rounding makes nothing negative


@dataclass(frozen=True, slots=True, eq=False)
class _Solution:
    estimate: Array
    gram_inverse: Array
    identifiable: NDArray[np.bool_]


def solve_linear(columns: Array, target: Array) -> Array:
    """(k,) least squares of ``columns`` (K, n, k) on ``target`` (K, n), both already weighted per row.

    Directions that the data do not excite stay at zero.
    """
    return _solve(columns, target).estimate


def solve_bounded(columns: Array, target: Array, size: Array, lower: Array, upper: Array) -> Array:
    """The same within bounds (k,), and along unexcited directions the smallest step in units of ``size``.

    A step that begins at a bound mostly ends at one: there it is looked for within the bounds first.
    """
    factor, scale = _factor(columns, target)
    if np.any(lower >= 0.0) or np.any(upper <= 0.0):
        step, binds = _within(factor, scale, size, lower, upper)
        if binds:
            return step
    free = _solution(factor, scale, size).estimate
    if np.all(free >= lower) and np.all(free <= upper):
        return free
    return _within(factor, scale, size, lower, upper)[0]


def _within(factor: Array, scale: Array, size: Array, lower: Array, upper: Array) -> tuple[Array, bool]:
    """The step within bounds, and whether any of them binds."""
    k = len(scale)
    scaled = factor[:k, :k] * (scale * size)
    # A whisper of a pull to zero keeps what the data do not tell in place.
    whisper = RANK_TOLERANCE * np.linalg.norm(scaled) * np.eye(k)
    whole = triangle(np.block([[scaled, factor[:k, k:]], [whisper, np.zeros((k, 1))]]))
    design, target = whole[:k, :k], whole[:k, k]
    limits = (lower / size, upper / size)
    with suppress(np.linalg.LinAlgError):  # LAPACK's divide and conquer fails once in very many times
        found = optimize.lsq_linear(design, target, bounds=limits, method="bvls")  # few bounds bind: quick, and exact
        if found.success:
            return np.asarray(found.x * size), bool(np.any(found.active_mask))
    found = optimize.lsq_linear(design, target, bounds=limits)
    return np.asarray(found.x * size), bool(np.any(found.active_mask))


def fit_linear(columns: Array, target: Array) -> LinearFit:
    """Least squares with its covariance: the sandwich estimator with Newey and West's (1987) correction.

    It allows for correlation along the K samples, since residuals of real machines are never white.
    """
    solution = _solve(columns, target)
    residual = target - times(columns, solution.estimate)
    scores = np.einsum("ijk,ij->ik", columns, residual)
    count, k = len(columns), columns.shape[2]
    middle = long_run_covariance(scores) * count
    covariance = solution.gram_inverse @ middle @ solution.gram_inverse * (count / max(count - k, 1))
    return LinearFit(solution.estimate, covariance, solution.identifiable)


def flat(columns: Array) -> Array:
    """(K, n, k) as (K n, k), where there are none, too."""
    return columns.reshape(columns.shape[0] * columns.shape[1], columns.shape[2])


def without(values: Array, columns: Array) -> Array:
    """Values (K, n, ...) less all that columns (K, n, k) could tell of them."""
    size = np.linalg.norm(columns, axis=(0, 1))
    given = flat(columns[:, :, size > 0.0] / size[size > 0.0])
    if not given.shape[1]:
        return values
    vectors, s, _ = svd(given, full_matrices=False)
    basis = vectors[:, s > RANK_TOLERANCE * s[0]]
    whole = values.reshape(len(given), -1)
    return np.asarray((whole - basis @ (basis.T @ whole)).reshape(values.shape))


def times(columns: Array, numbers: Array) -> Array:
    """(K, n, ...) columns (K, n, k) times numbers (k, ...): as one product of matrices, not as K small ones."""
    return np.asarray((flat(columns) @ numbers).reshape(*columns.shape[:2], *numbers.shape[1:]))


def _solve(columns: Array, target: Array) -> _Solution:
    return _solution(*_factor(columns, target))


def _factor(columns: Array, target: Array) -> tuple[Array, Array]:
    """Triangular factor of [design, target] with columns of unit length, and (k,) what these were divided by."""
    design = flat(columns)
    length = np.linalg.norm(design, axis=0)
    scale = np.where(length > 0, length, 1.0)
    return _triangle(design / scale, target), scale


def _solution(factor: Array, scale: Array, size: Array | None = None) -> _Solution:
    k = len(scale)
    # The triangular factor has the singular values of the design and is k x k.
    u, s, vt = svd(factor[:k, :k])
    keep = s > RANK_TOLERANCE * max(float(s.max(initial=0.0)), 1e-300)
    inverse = (vt[keep].T / s[keep]) / scale[:, None]
    estimate = inverse @ (u[:, keep].T @ factor[:k, k])
    lost = vt[~keep].T / scale[:, None]
    if lost.size and size is not None:
        estimate = estimate - lost @ least_squares(lost / size[:, None], estimate / size, rcond=None)
    hidden = np.abs(vt[~keep]).max(axis=0, initial=0.0) > 1e-3
    told = np.any(factor[:k, :k], axis=0)
    return _Solution(estimate, inverse @ inverse.T, ~hidden & told)


def _triangle(design: Array, target: Array) -> Array:
    """(k + 1, k + 1) triangular factor of [design, target]: all that least squares needs of them."""
    return triangle(np.column_stack([design, target.reshape(-1)]))


def triangle(rows: Array) -> Array:
    """(k, k) triangular factor of (m, k), with m rows where those are fewer.

    Tall ones are taken in blocks that fit a processor's cache, then the triangles of those (TSQR, Demmel et al. 2012).
    """
    count, k = rows.shape
    blocks = count // BLOCK if 0 < k < BLOCK // 2 else 0
    if blocks > 1:
        whole = rows[: blocks * BLOCK].reshape(blocks, BLOCK, k)
        return triangle(np.concatenate([_qr(whole).reshape(-1, k), rows[blocks * BLOCK :]]))
    return _qr(rows)


def _qr(rows: Array) -> Array:
    return np.asarray(np.linalg.qr(rows, mode="r"))


def likelier(before: Array, after: Array) -> tuple[float, float]:
    """The same test for joints whose noise is of unknown size, (K, n): the gain is that of the log-likelihood.

    Each joint's squares are taken over their logarithmic mean before and after, so that their fall is that of
    the logarithm: a joint that was fitted well already does not outweigh the one where something is missing.
    """
    old, new = (np.mean(errors**2, axis=0) + 1e-300 for errors in (before, after))
    ratio = np.log(old / new)
    size = np.where(np.abs(ratio) > 1e-6, (old - new) / np.where(ratio == 0.0, 1.0, ratio), old)
    return encompassing(before / np.sqrt(size), after / np.sqrt(size))


def log_loss(errors: Array) -> float:
    """Minus twice the log-likelihood per sample of errors (K, n) that is so measured, but for a constant."""
    return float(np.sum(np.log(np.mean(errors**2, axis=0) + 1e-300)))


def long_run_covariance(scores: Array) -> Array:
    """Newey-West: covariance of the mean of a correlated sequence (K, k), times K; Bartlett weights."""
    count = len(scores)
    centred = scores - scores.mean(axis=0)
    lags = int(np.ceil(4.0 * (count / 100.0) ** (2.0 / 9.0)))  # Newey and West's own rule
    lags = max(lags, _correlation_length(centred))
    reach = min(lags, count - 1)
    # The weighted sum of all lagged products at once: convolution theorem, padded so that nothing wraps around.
    length = _padded(count + reach)
    window = np.zeros(length)
    window[: reach + 1] = 1.0 - np.arange(reach + 1) / (lags + 1.0)
    window[length - reach :] = window[reach:0:-1]
    share = np.fft.rfft(window).real
    share[1:-1] *= 2.0  # of a real sequence, half the spectrum is kept
    spectrum = np.fft.rfft(centred, length, axis=0)
    return np.asarray((spectrum.conj().T @ (share[:, None] * spectrum)).real / (length * count))


def _padded(count: int) -> int:
    """An even length of at least so many samples, of which a Fourier transform is quick."""
    return 2 * int(fft.next_fast_len((count + 1) // 2, real=True))


def _correlation_length(scores: Array) -> int:
    """Samples until the autocorrelation of the slowest score has died away (first zero), at most K / 8."""
    count = len(scores)
    furthest = count // 8
    length = _padded(count + furthest)
    power = np.abs(np.fft.rfft(scores, length, axis=0)) ** 2
    correlation = np.fft.irfft(power, length, axis=0)[:furthest]
    if not furthest:
        return 0
    died = correlation <= 0
    first = np.where(np.any(died, axis=0), np.argmax(died, axis=0), furthest)
    return int(np.max(first, initial=0))


def encompassing(before: Array, after: Array) -> tuple[float, float]:
    """Whether one explanation holds something that another lacks, on data that neither was fitted to.

    ``before``, ``after`` (K, n) are their errors. Errors of the first are regressed on the difference
    of the two predictions: slope 0 if the second adds nothing, 1 if it has all that is missing
    (Chong and Hendry 1986; Harvey, Leybourne and Newbold 1998). Returns the mean fall of the squared
    error and the one-sided p-value of "adds nothing", correlated errors allowed for.
    """
    gain = float(np.mean(np.sum(before**2 - after**2, axis=1)))
    change = before - after
    power = float(np.sum(change**2))
    if power <= 1e-18 * float(np.sum(before**2)):
        return gain, 1.0
    slope = float(np.sum(change * before)) / power
    scores = np.sum(change * (before - slope * change), axis=1)
    spread = np.sqrt(max(float(long_run_covariance(scores[:, None])[0, 0]), 0.0) * len(scores)) / power
    return gain, float(stats.norm.sf(slope / max(spread, 1e-12)))
