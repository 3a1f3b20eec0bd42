"""The forms beside NAME and NAME_batch give the same numbers: in place, packed, on all cores, a state per column."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from symdyn.compiler import Compiled
from symdyn.emit.kernel import Kernel

Interpreted = Callable[[str], Kernel]
FUNCTIONS = ("inverse_dynamics", "mass_matrix", "forward_dynamics_state_jacobian")
COUNTS = (0, 1, 31, 32, 33, 100)  # around the size of a block
MACHINE = "two-link"


def arguments_of(compiled: Compiled, name: str, count: int) -> tuple[np.ndarray, ...]:
    program = next(form.program for form in compiled.forms if form.name == name)
    rng = np.random.default_rng(count)
    return tuple(rng.uniform(-2, 2, (count, len(a.symbols))) for a in program.arguments)


def one_by_one(kernel: Kernel, name: str, arguments: tuple[np.ndarray, ...]) -> np.ndarray:
    function = getattr(kernel, name)
    shape = function(*(np.ones(a.shape[1]) for a in arguments)).shape
    found: list[Any] = [function(*(a[k] for a in arguments)) for k in range(len(arguments[0]))]
    return np.array(found).reshape(len(found), *shape)


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_batches(name: str, count: int, compiled: Callable[[str], Compiled], interpreted: Interpreted) -> None:
    kernel = interpreted(MACHINE)
    arguments = arguments_of(compiled(MACHINE), name, count)
    wanted = one_by_one(kernel, name, arguments)
    columns = tuple(np.ascontiguousarray(a.T) for a in arguments)
    np.testing.assert_array_equal(getattr(kernel, f"{name}_batch")(*arguments), wanted)
    out = np.full(wanted.shape, np.nan)
    getattr(kernel, f"{name}_batch_into")(*arguments, out)
    np.testing.assert_array_equal(out, wanted)
    np.testing.assert_array_equal(getattr(kernel, f"{name}_batch_parallel")(*arguments), wanted)
    out = np.full(wanted.shape, np.nan)
    getattr(kernel, f"{name}_batch_parallel_into")(*arguments, out)
    np.testing.assert_array_equal(out, wanted)
    np.testing.assert_array_equal(np.moveaxis(getattr(kernel, f"{name}_soa")(*columns), -1, 0), wanted)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_one_state(name: str, compiled: Callable[[str], Compiled], interpreted: Interpreted) -> None:
    kernel = interpreted(MACHINE)
    arguments = arguments_of(compiled(MACHINE), name, 1)
    (wanted,) = one_by_one(kernel, name, arguments)
    out = np.full(wanted.shape, np.nan)
    getattr(kernel, f"{name}_into")(*(a[0] for a in arguments), out)
    np.testing.assert_array_equal(out, wanted)
    both = np.concatenate([*(a[0] for a in arguments), np.full(wanted.size, np.nan)])
    given = both.copy()
    getattr(kernel, f"{name}_packed")(both)
    np.testing.assert_array_equal(both[-wanted.size :], wanted.ravel())
    np.testing.assert_array_equal(both[: -wanted.size], given[: -wanted.size])


def test_packed_refuses_another_size(interpreted: Interpreted) -> None:
    with pytest.raises(ValueError, match=r"inverse_dynamics_packed takes 8 numbers: q, qd, qdd, result"):
        interpreted(MACHINE).inverse_dynamics_packed(np.zeros(7))


def test_batches_refuse_another_shape(interpreted: Interpreted) -> None:
    q = np.zeros((3, 2))
    with pytest.raises(ValueError, match=r"out must have the shape \(states, 2, 2\)"):
        interpreted(MACHINE).mass_matrix_batch_into(q, np.zeros((3, 4)))
    with pytest.raises(ValueError, match=r"out must have the shape \(states, 2\)"):
        interpreted(MACHINE).inverse_dynamics_batch_into(q, q, q, np.zeros((2, 2)))


def test_batches_refuse_results_that_are_not_contiguous(interpreted: Interpreted) -> None:
    q = np.zeros((3, 2))
    for form in ("batch_into", "batch_parallel_into"):
        with pytest.raises(ValueError, match="out must be contiguous"):
            getattr(interpreted(MACHINE), f"inverse_dynamics_{form}")(q, q, q, np.zeros((3, 4))[:, ::2])


@pytest.mark.parametrize("count", [1, 7, 8, 33, 71])
def test_compiled_batches_write_their_rows_and_nothing_else(count: int, compiled: Callable[[str], Compiled]) -> None:
    """Rows are stored eight at a time; functions with rows of different lengths share the code for it."""
    kernel = compiled(MACHINE).kernel()
    q, qd, qdd = arguments_of(compiled(MACHINE), "inverse_dynamics", count)
    masses, efforts = np.full((count + 8, 2, 2), np.nan), np.full((count + 8, 2), np.nan)
    kernel.mass_matrix_batch_into(q, masses[4:-4])
    kernel.inverse_dynamics_batch_into(q, qd, qdd, efforts[4:-4])
    for found in (masses, efforts):
        assert np.isnan(found[:4]).all()
        assert np.isnan(found[-4:]).all()
    wanted = [kernel.inverse_dynamics(*rows) for rows in zip(q, qd, qdd, strict=True)]
    np.testing.assert_allclose(efforts[4:-4], wanted, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(masses[4:-4], [kernel.mass_matrix(row) for row in q], rtol=1e-12)


def test_batches_take_integers_and_strided_rows(compiled: Callable[[str], Compiled]) -> None:
    kernel = compiled(MACHINE).kernel()
    rows = np.arange(12).reshape(3, 4)
    np.testing.assert_array_equal(kernel.gravity_batch(rows[:, ::2]), kernel.gravity_batch(rows[:, ::2] * 1.0))


def test_compiled_ones(compiled: Callable[[str], Compiled], interpreted: Interpreted) -> None:
    kernel, name = compiled(MACHINE).kernel(), "inverse_dynamics"
    arguments = arguments_of(compiled(MACHINE), name, 33)
    wanted = one_by_one(interpreted(MACHINE), name, arguments)
    columns = tuple(np.ascontiguousarray(a.T) for a in arguments)
    both = np.concatenate([*(a[0] for a in arguments), np.zeros(2)])
    kernel.inverse_dynamics_packed(both)
    np.testing.assert_allclose(both[-2:], wanted[0], rtol=1e-12)
    np.testing.assert_allclose(kernel.inverse_dynamics_soa(*columns).T, wanted, rtol=1e-11, atol=1e-12)
    rows = np.full_like(wanted, np.nan)
    kernel.inverse_dynamics_batch_into(*arguments, rows)
    np.testing.assert_allclose(rows, wanted, rtol=1e-11, atol=1e-12)
    masses = np.full((33, 2, 2), np.nan)
    kernel.mass_matrix_batch_into(arguments[0], masses)
    assert np.isfinite(masses).all()
    np.testing.assert_allclose(kernel.inverse_dynamics_batch_parallel(*arguments), wanted, rtol=1e-11, atol=1e-12)
    rows = np.full_like(wanted, np.nan)
    kernel.inverse_dynamics_batch_parallel_into(*arguments, rows)
    np.testing.assert_allclose(rows, wanted, rtol=1e-11, atol=1e-12)
