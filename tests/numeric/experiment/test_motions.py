"""Motions of experiments: from rest to rest, within limits, with derivatives that are those of the position."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.numeric.experiment.limits import JointLimits, Limits
from symdyn.numeric.experiment.motions import MOST_SWEEPS, Family

LIMITS = Limits((JointLimits(-1.0, 1.0, 2.0, 10.0), JointLimits(0.2, 0.5, 0.3, np.inf)))
FAMILY = Family(LIMITS, 12.0)
points = st.integers(0, 2**32 - 1).map(lambda seed: np.random.default_rng(seed).random(FAMILY.size))


@given(points)
@settings(max_examples=40)
def test_motion_starts_and_ends_at_rest_within_its_limits(point: np.ndarray) -> None:
    motion = FAMILY.motion(point, 4001)
    for values in (motion.qd, motion.qdd):
        np.testing.assert_allclose(values[[0, -1]], 0.0, atol=1e-9)
    for j, joint in enumerate(LIMITS.joints):
        assert joint.lower <= motion.q[:, j].min() < motion.q[:, j].max() <= joint.upper
        assert np.abs(motion.qd[:, j]).max() <= joint.velocity
        assert np.abs(motion.qdd[:, j]).max() <= joint.acceleration
    np.testing.assert_allclose(motion.time[[0, -1]], [0.0, 12.0])


@given(points)
@settings(max_examples=20)
def test_speed_and_acceleration_are_derivatives_of_the_position(point: np.ndarray) -> None:
    coarse, fine = (_errors_of_differences(point, count) for count in (12001, 48001))
    # wrong by step^2 where it is smooth, and by step in the few samples beside a kink: on average by step^2
    for before, after in zip(coarse, fine, strict=True):
        assert after <= 0.15 * before


def _errors_of_differences(point: np.ndarray, count: int) -> list[float]:
    """Of central differences of position and speed: mean, as a share of the largest."""
    motion = FAMILY.motion(point, count)
    found = []
    for low, high in ((motion.q, motion.qd), (motion.qd, motion.qdd)):
        differences = np.gradient(low, motion.time, axis=0)[1:-1]
        found.append(float(np.abs(differences - high[1:-1]).mean() / np.abs(high).max()))
    return found


def test_sweeps_run_at_constant_speed() -> None:
    point = np.full(FAMILY.size, 0.5)
    point[0] = 1.0  # nearly all the time sweeps
    point[4 : 4 + 1] = 0.0  # no travel of the series
    motion = FAMILY.motion(point, 20001)
    sweeping = motion.time < 0.9 * 12.0
    speed = np.abs(motion.qd[sweeping, 0])
    assert np.mean(np.abs(speed - np.median(speed)) < 1e-9) > 0.6
    turns = np.sum(np.diff(np.sign(motion.qd[sweeping, 0])) != 0)
    assert turns == pytest.approx(2.0 * MOST_SWEEPS**0.5, abs=2)


def test_scale_shrinks_the_motion_about_its_centre() -> None:
    point = np.full(FAMILY.size, 0.4)
    whole, half = (FAMILY.motion(point, 2001, scale) for scale in (1.0, 0.5))
    np.testing.assert_allclose(half.q - half.q[0], 0.5 * (whole.q - whole.q[0]), atol=1e-12)
    np.testing.assert_allclose(half.qdd, 0.5 * whole.qdd, atol=1e-9)


def test_table_names_joints_and_units() -> None:
    table = FAMILY.motion(np.full(FAMILY.size, 0.4), 20).table(("lift", "elbow"), ("m", "rad"))
    assert list(table) == [
        "time [s]", "lift.q [m]", "elbow.q [rad]", "lift.qd [m/s]", "elbow.qd [rad/s]", "lift.qdd [m/s^2]",
        "elbow.qdd [rad/s^2]",
    ]  # fmt: skip
