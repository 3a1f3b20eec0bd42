"""How far an interval reaches where the likelihood falls less than its curvature says."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.numeric.filtering.beliefs import Belief
from symdyn.numeric.filtering.likelihood import MLFit
from symdyn.numeric.filtering.reach import with_reach

SE = 0.1


def fitted(loss: Callable[[float, float], float], covariance: NDArray[np.float64]) -> MLFit:
    """A fit of two numbers, 3 and 1, whose -log L is given."""
    bench: Any = SimpleNamespace(index={"a": 0, "b": 1})
    bench.filtered = lambda p: SimpleNamespace(loss=loss(p[0] - 3.0, p[1] - 1.0))
    fit = MLFit({"a": Belief(), "b": Belief()}, np.array([3.0, 1.0]), bench, loss(0.0, 0.0))
    fit.__dict__["covariance"] = covariance
    return fit


def test_of_a_parabola_it_is_what_its_curvature_says() -> None:
    tight = np.array([[2.0, -1.0], [-1.0, 2.0]]) / SE**2
    fit = fitted(lambda a, b: 0.5 * np.array([a, b]) @ tight @ np.array([a, b]), np.linalg.inv(tight))
    told = with_reach(fit, ["a", "b"])
    assert told.reach == pytest.approx([1.0, 1.0])


def test_where_one_side_is_flat_it_reaches_as_far_as_that_does() -> None:
    """-log L rises by two at 0.2 above, and at 0.5 below."""
    fit = fitted(lambda a, b: 0.5 * ((a if a > 0.0 else 0.4 * a) / SE) ** 2 + 0.5 * (b / SE) ** 2, SE**2 * np.eye(2))
    told = with_reach(fit, ["a"])
    assert told.reach == pytest.approx([2.5, 1.0])


def test_where_nothing_tells_it_ends_somewhere() -> None:
    told = with_reach(fitted(lambda a, b: 0.0, SE**2 * np.eye(2)), ["a"])
    assert told.reach == pytest.approx([16.0, 1.0])


def test_robust_errors_that_are_larger_stay() -> None:
    told = with_reach(fitted(lambda a, b: 5.0 * ((a / SE) ** 2 + (b / SE) ** 2), SE**2 * np.eye(2)), ["a", "b"])
    assert told.reach == pytest.approx([1.0, 1.0])


def test_what_was_not_fitted_has_none() -> None:
    fit = fitted(lambda a, b: a * a + b * b, SE**2 * np.eye(2))
    assert with_reach(fit, ["c"]) is fit
