"""What is left is asked joint by joint: the noise of many does not hide what one of them lacks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.numeric.leftover import leftover

Array = NDArray[np.float64]

JOINTS = 6
NAMES = [f"{what} of j{j}" for what in ("position", "speed") for j in range(JOINTS)]
ERRORS = {f"j{j}": 0.01 * (j + 1) for j in range(JOINTS)}
OVERALL = float(np.sqrt(np.mean(np.square(list(ERRORS.values())))))


def recorded(seed: int, of: float) -> tuple[Array, Array]:
    """White residuals of six joints, and their motion; the third has a bump of friction at one angle besides."""
    rng = np.random.default_rng(seed)
    motion = rng.uniform(-1.0, 1.0, (1500, 2 * JOINTS))
    residual = rng.normal(size=(1500, JOINTS))
    residual[:, 2] += of * np.exp(-((motion[:, 2] / 0.3) ** 2)) * motion[:, JOINTS + 2]
    return residual, motion


def test_what_one_joint_lacks_is_told_with_its_place() -> None:
    left = leftover(recorded(1, 2.0), recorded(2, 2.0), NAMES, ERRORS, 4.0)
    assert (left.structured, left.place, left.variable) == (True, "j2", "position of j2 and speed of j2")
    assert left.heldout == pytest.approx(OVERALL)
    assert 0.1 * 0.03 < left.size < 0.03
    assert left.share == pytest.approx(left.size**2 / (JOINTS * OVERALL**2))  # of the power of all joints


def test_noise_of_many_joints_is_no_structure() -> None:
    told = [leftover(recorded(2 * s, 0.0), recorded(2 * s + 1, 0.0), NAMES, ERRORS, 4.0) for s in range(10)]
    assert not any(left.structured for left in told)
    assert max(left.share for left in told) < 0.01


def test_what_is_slow_is_told_where_it_is() -> None:
    rest, motion = recorded(3, 0.0)
    rest[:, 4] = np.convolve(rest[:, 4], np.ones(30), mode="same")
    left = leftover(recorded(4, 0.0), (rest, motion), NAMES, ERRORS, 4.0)
    assert (left.structured, left.place, left.variable) == (True, "j4", None)


def test_what_is_slow_is_no_less_beside_a_little_that_follows_the_motion() -> None:
    runs = [recorded(1, 2.0), recorded(2, 2.0)]
    alone = leftover(*runs, NAMES, ERRORS, 4.0)
    for residual, _ in runs:
        residual[:, 4] = np.convolve(residual[:, 4], np.ones(30), mode="same")
    left = leftover(*runs, NAMES, ERRORS, 4.0)
    assert (left.structured, left.place, left.variable) == (True, "j2", alone.variable)
    assert alone.slow == 0.0
    assert left.slow > 0.8 * 0.05**2 / (JOINTS * OVERALL**2) > 2.0 * left.share
    assert left.size > alone.size
