"""One step between samples against SciPy's matrix exponential."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg

from symdyn.numeric.filtering.transition import product, transition


@pytest.mark.parametrize("size", [1e-3, 1.0, 50.0, 2e4])
@pytest.mark.parametrize("seed", range(5))
def test_change_and_integrals_are_those_of_the_exponential(size: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, step = 6, 1e-3
    a = size * rng.normal(size=(n, n)) - 2.0 * size * np.eye(n)
    change, integral, ramp = (np.zeros((n, n)) for _ in range(3))
    transition(a, step, change, integral, ramp)
    wide = np.zeros((3 * n, 3 * n))  # Van Loan 1978: the integrals are blocks of one exponential
    wide[:n, :n], wide[:n, n : 2 * n], wide[n : 2 * n, 2 * n :] = a, np.eye(n), np.eye(n)
    whole = linalg.expm(wide * step)
    np.testing.assert_allclose(change + np.eye(n), whole[:n, :n], rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(integral, whole[:n, n : 2 * n], rtol=1e-9, atol=1e-10 * step)
    np.testing.assert_allclose(ramp, whole[:n, 2 * n :], rtol=1e-9, atol=1e-10 * step**2)


def test_a_singular_machine_drifts() -> None:
    """A mass without spring: position grows with speed."""
    change, integral, ramp = (np.zeros((2, 2)) for _ in range(3))
    transition(np.array([[0.0, 1.0], [0.0, 0.0]]), 0.5, change, integral, ramp)
    np.testing.assert_allclose(ramp, [[0.125, 0.125 / 6.0], [0.0, 0.125]], atol=1e-15)
    np.testing.assert_allclose(change, [[0.0, 0.5], [0.0, 0.0]], atol=1e-15)
    np.testing.assert_allclose(integral, [[0.5, 0.125], [0.0, 0.5]], atol=1e-15)


def test_product_of_rectangles() -> None:
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(3, 5)), rng.normal(size=(5, 4))
    out = np.zeros((3, 4))
    product(a, b, out)
    np.testing.assert_allclose(out, a @ b, rtol=1e-14)
