"""D-optimal motions: standard errors that come out as promised, and parameters that no motion tells."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.numeric.experiment.identification import identifying

from ..pendulum import ARM, GRAVITY, MASS
from .rods import NOISE, limits, rod

DURATION = 20.0


def test_standard_errors_are_those_of_least_squares() -> None:
    found = identifying(rod("ripple"), limits(1.5), NOISE, DURATION, evaluations=200)
    q, v, a = (values[:, 0] for values in (found.motion.q, found.motion.qd, found.motion.qdd))
    slope = -0.2 * q * np.sin(11 * q) + 0.2 * q * np.cos(11 * q)
    columns = np.column_stack([a, v, np.cos(q), np.cos(11 * q), np.sin(11 * q), slope])
    information = columns.T @ columns / NOISE.sigma[0] ** 2 * DURATION * NOISE.rate / len(q)
    expected = np.sqrt(np.diag(np.linalg.inv(information)))
    told = found.standard_errors
    names = ("b", "arm_torque_ripple_cosine", "arm_torque_ripple_sine", "arm_torque_ripple_order")
    for name, error in zip(names, expected[[1, 3, 4, 5]], strict=True):
        assert told[name] == pytest.approx(error, rel=0.03)  # half as many samples were searched on


def test_what_no_motion_tells_by_itself_is_named() -> None:
    found = identifying(rod("offset"), limits(1.0), NOISE, DURATION, evaluations=64)
    assert {name for name, error in found.standard_errors.items() if error is None} == {"m", "r", "I"}
    assert MASS * ARM * GRAVITY > 0  # they act together as m r and I + m r^2


def test_designed_motion_tells_more_than_the_usual_one() -> None:
    few, many = (identifying(rod("ripple"), limits(1.0), NOISE, DURATION, evaluations=n) for n in (32, 600))
    assert many.gain >= few.gain > 1.0
    assert many.gain > 1.5
    again = identifying(rod("ripple"), limits(1.0), NOISE, DURATION, evaluations=600)
    assert again.motion.q.tobytes() == many.motion.q.tobytes()
