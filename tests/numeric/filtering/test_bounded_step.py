"""Steps within bounds, against all others on a grid."""

from __future__ import annotations

import numpy as np

from symdyn.numeric.filtering.bounded_step import bounded_step


def test_a_step_that_meets_its_bounds_leads_downhill() -> None:
    """Numbers make up for each other, and for one that may not go as far: the free step, cut off, leads uphill."""
    root = np.array([[1.45, 0.0, 0.0], [-0.83, 1.07, 0.0], [-0.07, 0.07, 0.02]])
    sides, slope = root @ root.T, -np.array([0.29, 0.03, 0.55])

    def promised(step: np.ndarray) -> float:
        return float(step @ (slope - 0.5 * sides @ step))

    cut_off = np.clip(np.linalg.solve(sides, slope), -2.0, 2.0)
    step = bounded_step(sides, slope, np.full(3, -2.0), np.full(3, 2.0))
    assert promised(cut_off) < 0.0 < promised(step)
    assert np.all(np.abs(step) <= 2.0)
    grid = np.stack(np.meshgrid(*[np.linspace(-2.0, 2.0, 41)] * 3), axis=-1).reshape(-1, 3)
    assert promised(step) >= max(promised(each) for each in grid)
    below = bounded_step(sides, slope, np.array([-0.5, 0.0, -1.0]), np.array([0.0, 0.5, 1.0]))
    assert np.all((below >= [-0.5, 0.0, -1.0]) & (below <= [0.0, 0.5, 1.0]))


def test_a_step_that_meets_none_is_the_free_one() -> None:
    sides, slope = np.array([[2.0, 0.5], [0.5, 1.0]]), np.array([0.3, -0.7])
    free = bounded_step(sides, slope, np.full(2, -np.inf), np.full(2, np.inf))
    np.testing.assert_allclose(sides @ free, slope, rtol=1e-12)
