"""Where LAPACK's divide and conquer does not converge, its plain iteration gives the same."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.numeric.decomposition import Array, least_squares, pseudo_inverse, svd

TALL = np.random.default_rng(1).standard_normal((12, 4)) @ np.diag([1.0, 1e-3, 1.0, 0.0])  # of rank three
RIGHT = np.random.default_rng(2).standard_normal(12)
RCOND = 1e-9


@pytest.fixture(params=[False, True], ids=["divide and conquer", "plain"])
def _lapack(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param:

        def fails(*args: object, **kwargs: object) -> None:
            raise np.linalg.LinAlgError("SVD did not converge")

        monkeypatch.setattr(np.linalg, "svd", fails)
        monkeypatch.setattr(np.linalg, "lstsq", fails)


@pytest.mark.usefixtures("_lapack")
@pytest.mark.parametrize("full", [False, True])
def test_singular_values(full: bool) -> None:
    u, s, vt = svd(TALL, full_matrices=full)
    assert u.shape == (12, 12 if full else 4)
    np.testing.assert_allclose((u[:, :4] * s) @ vt, TALL, atol=1e-14)
    np.testing.assert_allclose(u.T @ u, np.eye(u.shape[1]), atol=1e-14)
    assert np.all(np.diff(s) <= 0)


@pytest.mark.usefixtures("_lapack")
def test_least_squares_leave_at_zero_what_is_not_told() -> None:
    found = least_squares(TALL, RIGHT, RCOND)
    np.testing.assert_allclose(TALL.T @ (TALL @ found - RIGHT), np.zeros(4), atol=1e-10)  # x is of size 100
    assert found[3] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.usefixtures("_lapack")
def test_pseudo_inverse_is_that_of_penrose() -> None:
    inverse: Array = pseudo_inverse(TALL, RCOND)
    np.testing.assert_allclose(TALL @ inverse @ TALL, TALL, atol=1e-12)
    np.testing.assert_allclose(inverse @ TALL @ inverse, inverse, atol=1e-9)
    np.testing.assert_allclose((TALL @ inverse).T, TALL @ inverse, atol=1e-12)
