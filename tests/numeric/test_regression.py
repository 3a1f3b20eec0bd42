"""Least squares against numpy, its bounds, and standard errors that hold for what they are said to hold for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import optimize, signal

from symdyn.numeric.regression import encompassing, fit_linear, long_run_covariance, solve_bounded, solve_linear

Array = NDArray[np.float64]

DRAWS = 400  # a standard deviation from so many draws is itself known to 1 / sqrt(2 * 400) = 3.5 %
FOUR_SIGMA = 4.0 / np.sqrt(2.0 * DRAWS)


def problem(seed: int, count: int = 60, outputs: int = 2, k: int = 3) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    scale = 10.0 ** rng.uniform(-3, 3, k)  # parameters come in all units
    return rng.standard_normal((count, outputs, k)) * scale, rng.standard_normal((count, outputs))


def smooth_design(count: int) -> Array:
    """(count, 1, 2): a slow and a less slow wave, as regressors of a motion are."""
    phase = 2 * np.pi * np.arange(count) / count
    return np.stack([np.sin(3 * phase), np.cos(8 * phase + 0.4)], axis=1)[:, None, :]


def correlated(rng: np.random.Generator, count: int, phi: float) -> Array:
    """AR(1) noise of unit innovations, stationary from its first sample on."""
    innovations = rng.standard_normal(count + 500)
    return np.asarray(signal.lfilter([1.0], [1.0, -phi], innovations)[500:])


def scatter_and_stated(phi: float, count: int = 2000) -> tuple[Array, Array, Array]:
    """Scatter of the estimates over draws, the mean stated error, and what ordinary least squares would state."""
    rng, design = np.random.default_rng(5), smooth_design(count)
    flat = design[:, 0]
    inverse = np.linalg.inv(flat.T @ flat)
    estimates, stated, ordinary = [], [], []
    for _ in range(DRAWS):
        target = flat @ [2.0, -1.0] + correlated(rng, count, phi)
        fit = fit_linear(design, target[:, None])
        left = target - flat @ fit.estimate
        estimates.append(fit.estimate)
        stated.append(fit.standard_error)
        ordinary.append(np.sqrt(np.diag(inverse) * (left @ left) / (count - 2)))
    return np.std(estimates, axis=0, ddof=1), np.mean(stated, axis=0), np.mean(ordinary, axis=0)


@given(seed=st.integers(0, 2**32 - 1))
def test_estimate_is_that_of_numpy(seed: int) -> None:
    columns, target = problem(seed)
    expected = np.linalg.lstsq(columns.reshape(-1, 3), target.reshape(-1), rcond=None)[0]
    for found in (solve_linear(columns, target), fit_linear(columns, target).estimate):
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-10)


@given(seed=st.integers(0, 2**32 - 1))
def test_units_of_a_parameter_do_not_matter(seed: int) -> None:
    columns, target = problem(seed)
    factor = np.array([1e-6, 1.0, 1e6])
    plain, scaled = fit_linear(columns, target), fit_linear(columns * factor, target)
    np.testing.assert_allclose(scaled.estimate * factor, plain.estimate, rtol=1e-8, atol=1e-10)
    np.testing.assert_allclose(scaled.standard_error * factor, plain.standard_error, rtol=1e-8)


def test_directions_without_data_stay_at_zero_and_are_not_called_known() -> None:
    rng = np.random.default_rng(0)
    one, other = rng.standard_normal((2, 50, 1))
    columns = np.stack([one, 2 * one, other, np.zeros((50, 1))], axis=2)  # the first two as one, the last not at all
    fit = fit_linear(columns, 5.0 * one + 3.0 * other)
    assert fit.identifiable.tolist() == [False, False, True, False]
    np.testing.assert_allclose(fit.estimate[2:], [3.0, 0.0], atol=1e-12)
    assert fit.estimate[0] + 2 * fit.estimate[1] == pytest.approx(5.0, rel=1e-12)


def test_unexcited_direction_takes_the_smallest_step_in_units_of_the_sizes() -> None:
    one = np.random.default_rng(0).standard_normal((50, 1))
    columns = np.stack([one, one], axis=2)
    free = (np.full(2, -np.inf), np.full(2, np.inf))
    for size in ([1.0, 1.0], [1.0, 3.0]):
        # minimise (x/s)^2 + (y/t)^2 on x + y = 10: shares go with the squares of the sizes
        expected = 10.0 * np.square(size) / np.sum(np.square(size))
        np.testing.assert_allclose(solve_bounded(columns, 10.0 * one, np.array(size), *free), expected, rtol=1e-9)


@settings(max_examples=50)
@given(seed=st.integers(0, 2**32 - 1), begins_at_bounds=st.booleans())
def test_bounded_solution_is_optimal(seed: int, begins_at_bounds: bool) -> None:
    """Karush, Kuhn and Tucker: flat where free, and at a bound the loss would fall only beyond it."""
    rng = np.random.default_rng(seed)
    columns = rng.standard_normal((60, 2, 3))
    target = columns @ rng.uniform(-3, 3, 3) + 0.1 * rng.standard_normal((60, 2))
    lower, upper = rng.uniform(-2.0, -0.5, 3), rng.uniform(0.5, 2.0, 3)
    if begins_at_bounds:
        lower[0], upper[1] = 0.0, 0.0
    found = solve_bounded(columns, target, np.ones(3), lower, upper)
    assert np.all(found >= lower - 1e-9)
    assert np.all(found <= upper + 1e-9)
    gradient = np.einsum("ijk,ij->k", columns, columns @ found - target) / 120
    for value, slope, low, high in zip(found, gradient, lower, upper, strict=True):
        if value - low < 1e-4:
            assert slope > -1e-3
        elif high - value < 1e-4:
            assert slope < 1e-3
        else:
            assert abs(slope) < 1e-3


def test_bounds_hold_where_lapack_gives_up(monkeypatch: pytest.MonkeyPatch) -> None:
    columns, target = np.array([[[1.0, 1.0]], [[0.0, 1.0]], [[1.0, 0.0]]]), np.array([[4.0], [1.0], [3.0]])
    plain = optimize.lsq_linear

    def fails(*args: Any, method: str = "trf", **options: Any) -> Any:
        if method == "bvls":
            raise np.linalg.LinAlgError
        return plain(*args, method=method, **options)

    monkeypatch.setattr(optimize, "lsq_linear", fails)
    found = solve_bounded(columns, target, np.ones(2), np.full(2, -np.inf), np.array([1.0, np.inf]))
    np.testing.assert_allclose(found, [1.0, 2.0], atol=1e-4)


def test_bound_that_binds_moves_the_other_parameters() -> None:
    """Not the same as clipping: with x held at 1, y takes over what it can."""
    columns = np.array([[[1.0, 1.0]], [[0.0, 1.0]], [[1.0, 0.0]]])
    target = columns @ [3.0, 1.0]
    found = solve_bounded(columns, target, np.ones(2), np.array([-np.inf, -np.inf]), np.array([1.0, np.inf]))
    np.testing.assert_allclose(found, [1.0, 2.0], atol=1e-4)


def test_stated_errors_cover_the_scatter_under_white_noise() -> None:
    scatter, stated, ordinary = scatter_and_stated(0.0)
    np.testing.assert_allclose(stated / ordinary, 1.0, atol=0.10)
    np.testing.assert_allclose(ordinary / scatter, 1.0, atol=FOUR_SIGMA)
    np.testing.assert_allclose(stated / scatter, 1.0, atol=FOUR_SIGMA + 0.10)


@pytest.mark.parametrize("phi", [0.6, 0.9])
def test_stated_errors_cover_the_scatter_under_correlated_noise(phi: float) -> None:
    """Newey and West's error is a little low in any finite sample: 15 % are allowed beyond the statistics."""
    scatter, stated, ordinary = scatter_and_stated(phi)
    ratio = stated / scatter
    assert np.all(ratio > 1.0 - FOUR_SIGMA - 0.15)
    assert np.all(ratio < 1.0 + FOUR_SIGMA)
    assert np.all(ordinary / scatter < 0.6)  # the test can tell: ordinary errors are far too small


def test_long_run_covariance_of_correlated_noise() -> None:
    """Of AR(1) it is 1 / (1 - phi)^2; Bartlett's weights over 13 lags are 14 % low at 0.7, the scatter is 2 %."""
    rng = np.random.default_rng(2)
    for phi in (-0.5, 0.0, 0.7):
        found = [long_run_covariance(correlated(rng, 20_000, phi)[:, None])[0, 0] for _ in range(20)]
        assert np.mean(found) == pytest.approx(1.0 / (1.0 - phi) ** 2, rel=0.18)


@pytest.mark.parametrize("count", [1, 2, 7, 8, 9, 100, 257])
def test_long_run_covariance_is_the_weighted_sum_of_lagged_products(count: int) -> None:
    scores = np.cumsum(np.random.default_rng(4).standard_normal((count, 2)), axis=0)
    scores -= scores.mean(axis=0)
    reach = int(np.ceil(4.0 * (count / 100.0) ** (2.0 / 9.0)))
    for column in scores.T:
        lagged = [float(column[lag:] @ column[: count - lag]) for lag in range(count // 8)]
        died = [lag for lag, product in enumerate(lagged) if product <= 0.0]
        reach = max(reach, died[0] if died else len(lagged))
    expected = scores.T @ scores / count
    for lag in range(1, min(reach, count - 1) + 1):
        product = scores[lag:].T @ scores[: count - lag] / count
        expected = expected + (1.0 - lag / (reach + 1.0)) * (product + product.T)
    np.testing.assert_allclose(long_run_covariance(scores), expected, rtol=1e-9, atol=1e-12)


def test_long_run_covariance_is_symmetric_and_not_negative() -> None:
    rng = np.random.default_rng(3)
    scores = np.column_stack([correlated(rng, 300, phi) for phi in (0.9, -0.8, 0.2)])
    found = long_run_covariance(scores @ rng.standard_normal((3, 3)))
    np.testing.assert_allclose(found, found.T, rtol=1e-12)
    assert np.linalg.eigvalsh(found).min() > 0


def encompassing_p_values(share: float, phi: float) -> Array:
    """Over draws: an effect of which the second explanation has ``share``, beside a useless guess of its own."""
    rng, found = np.random.default_rng(7), []
    wave = np.sin(np.arange(500) / 9.0)
    for _ in range(DRAWS):
        noise, guess = correlated(rng, 500, phi), correlated(rng, 500, phi)
        before = noise + share * wave
        found.append(encompassing(before[:, None], (before - share * wave - 0.3 * guess)[:, None])[1])
    return np.array(found)


@pytest.mark.parametrize("phi", [0.0, 0.8])
def test_useless_explanation_is_seldom_called_useful(phi: float) -> None:
    """At a level of 0.05, 20 of 400 by chance, with a standard deviation of 4.4."""
    alarms = int(np.sum(encompassing_p_values(0.0, phi) < 0.05))
    assert 2 <= alarms <= 44  # 44: the estimated spread is a little low under correlation


def test_useful_explanation_is_recognised() -> None:
    assert np.mean(encompassing_p_values(1.0, 0.0) < 0.01) > 0.99


def test_encompassing_measures_the_fall_of_the_squared_error() -> None:
    before, after = np.array([[3.0, 1.0], [1.0, 1.0]]), np.array([[1.0, 1.0], [0.0, 0.0]])
    assert encompassing(before, after)[0] == pytest.approx((8.0 + 2.0) / 2)
    assert encompassing(before, before) == (0.0, 1.0)


def test_explanation_of_the_wrong_sign_is_worse_than_none() -> None:
    truth = np.random.default_rng(4).standard_normal((400, 1))
    gain, p_value = encompassing(0.1 * truth, truth)
    assert gain < 0
    assert p_value > 0.99
