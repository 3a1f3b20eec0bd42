"""Many columns of one system in vectors of eight: the same as plain Python, and as the solution."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numba import njit

from symdyn.compiler import Compiled
from symdyn.emit.kernel import Kernel

SIZE = 4
Machine = Callable[[str], Compiled]


def solved_in_place(kernel: Kernel, start: int, width: int, first: tuple[int, ...], places: Any) -> Callable[..., Any]:
    """The last step of a function of the kernel, as it is compiled, or as it is in plain Python."""
    solve = kernel.module._columns(start, width, first, places)

    def one(out: Any, numbers: Any) -> None:
        solve(out, numbers)

    return njit(one) if hasattr(kernel.inverse_dynamics, "py_func") else one


def random_factors(rng: np.random.Generator, places: list[tuple[int, int]]) -> tuple[np.ndarray, tuple[float, ...]]:
    """The matrix, and its factors and reciprocals as a kernel hands them over."""
    f, pivots = np.eye(SIZE), rng.uniform(0.5, 2.0, SIZE)
    for place in places:
        f[place] = rng.normal()
    numbers = (*(float(f[place]) for place in places), *(1.0 / pivots).tolist())
    return f.T @ np.diag(pivots) @ f, numbers


@pytest.mark.parametrize("width", [8, 9, 12, 16, 17, 35])
@pytest.mark.parametrize("full", [True, False])
def test_widths(width: int, full: bool, compiled: Machine, interpreted: Callable[[str], Kernel]) -> None:
    rng = np.random.default_rng(width)
    every = [(k, i) for k in range(SIZE) for i in range(k)]
    places = every if full else every[::2]
    first = (0,) * SIZE if full else (0, 0, width - 2, width)
    matrix, numbers = random_factors(rng, places)
    right = rng.normal(size=(SIZE, width))
    for row, filled in zip(right, first, strict=True):
        row[:filled] = 0.0
    start = 5
    given = np.concatenate([np.full(start, 7.0), right.ravel(), [8.0]])
    wanted = np.concatenate([np.full(start, 7.0), np.linalg.solve(matrix, right).ravel(), [8.0]])
    for kernel in (compiled("two-link").kernel(), interpreted("two-link")):
        out = given.copy()
        solved_in_place(kernel, start, width, first, tuple(places))(out, numbers)
        np.testing.assert_allclose(out, wanted, rtol=1e-12, atol=1e-13)


def assert_same_in_rows(kernel: Kernel) -> None:
    rng = np.random.default_rng(0)
    q, qd, tau = rng.uniform(-2, 2, (3, 3, len(kernel.coordinates)))
    one_by_one = [kernel.forward_dynamics_state_jacobian(*rows) for rows in zip(q, qd, tau, strict=True)]
    np.testing.assert_allclose(kernel.forward_dynamics_state_jacobian_batch(q, qd, tau), one_by_one, rtol=1e-10)


def test_an_arm_one_by_one_and_in_rows(compiled: Machine, interpreted: Callable[[str], Kernel]) -> None:
    forms = {form.name: form for form in compiled("stanford").forms}
    assert forms["forward_dynamics_state_jacobian"].columns is not None
    assert_same_in_rows(interpreted("stanford"))


@pytest.mark.slow
def test_a_compiled_arm(compiled: Machine) -> None:
    assert_same_in_rows(compiled("stanford").kernel())


def test_results_that_are_not_contiguous_are_refused(compiled: Machine, interpreted: Callable[[str], Kernel]) -> None:
    for kernel in (compiled("two-link").kernel(), interpreted("two-link")):
        q = np.array([0.1, 0.2])
        for out in (np.zeros((4, 4))[:2, :2], np.zeros((2, 2), order="F")):
            with pytest.raises(ValueError, match="out must be contiguous"):
                kernel.mass_matrix_into(q, out)
