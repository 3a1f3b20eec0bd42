"""Profile likelihood: the intervals of linear parameters, what other parameters can take up, and coverage."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from symdyn.numeric.candidates import bounds
from symdyn.numeric.identify import Fitted, fitted
from symdyn.numeric.profile_likelihood import Identified, Profile, profile
from symdyn.spec.records import Robot

from .pendulum import ARM, INERTIA, MASS, VISCOUS, Array, pendulum, record, recording

QUANTILE = float(np.sqrt(stats.chi2.ppf(0.95, 1)))


@pytest.fixture(scope="module")
def robot() -> Robot:
    return pendulum()


@pytest.fixture(scope="module")
def fit(robot: Robot) -> Fitted:
    return fitted(robot, record(1))


def test_interval_of_a_linear_parameter_is_that_of_its_standard_error(robot: Robot, fit: Fitted) -> None:
    found = profile(fit, "b", bounds(robot))
    error = fit.fit.standard_error("b")
    assert error is not None
    assert found.identified is Identified.YES
    assert found.lower == pytest.approx(found.estimate - QUANTILE * error, abs=1e-2 * error)
    assert found.upper == pytest.approx(found.estimate + QUANTILE * error, abs=1e-2 * error)
    # The curve is a parabola, twice the log-likelihood in units of the standard error; the two count the memory of
    # the residual along different directions.
    expected = ((np.array(found.values) - found.estimate) / error) ** 2
    np.testing.assert_allclose(found.rise, expected, rtol=0.02, atol=1e-6)


def test_mass_is_bounded_on_one_side_by_an_inertia_that_is_not_negative(robot: Robot, fit: Fitted) -> None:
    """m r and I + m r^2 are told: m grows for ever, and shrinks until nothing is left of I."""
    found = profile(fit, "m", bounds(robot))
    moment, turning = MASS * ARM, INERTIA + MASS * ARM**2
    assert found.identified is Identified.PRACTICALLY_NOT
    assert found.upper is None
    assert found.lower == pytest.approx(moment**2 / turning, rel=0.02)


@pytest.mark.slow
def test_intervals_cover_the_truth_though_residuals_are_correlated(robot: Robot) -> None:
    """Noise that remembers 0.1 s: an interval for white residuals would be several times too short."""
    inside, length = 0, []
    for seed in range(20):
        clean = record(seed, noise=False)
        slow = _slow_noise(seed, len(clean.time))
        q, tau = (clean.channels[key] for key in clean.channels)
        done = fitted(robot, recording(clean.time, q, tau + slow), band=10.0)
        found = profile(done, "b", bounds(robot))
        assert found.lower is not None
        assert found.upper is not None
        inside += found.lower <= VISCOUS <= found.upper
        length.append(found.upper - found.lower)
    assert inside >= 16


def _slow_noise(seed: int, count: int) -> Array:
    rng = np.random.default_rng([seed, 5])
    found, keep = np.zeros(count), np.exp(-1.0 / 50.0)
    for i, drawn in enumerate(rng.standard_normal(count) * 0.02 * np.sqrt(1 - keep**2)):
        found[i] = keep * found[i - 1] + drawn
    return found


def test_facts_for_programs(robot: Robot, fit: Fitted) -> None:
    told = profile(fit, "b", bounds(robot)).to_json()
    assert told["identified"] == "identified"
    assert told["interval"][0] < told["estimate"] < told["interval"][1]
    assert len(told["curve"]["values"]) == len(told["curve"]["rise"]) == 17
    assert isinstance(profile(fit, "b", bounds(robot)), Profile)
