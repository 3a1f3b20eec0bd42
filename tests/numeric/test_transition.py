"""One step between samples against SciPy's matrix exponential."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import linalg

from symdyn.numeric.transition import HALVES, double, product, room, source_weights, transition

Array = NDArray[np.float64]


def with_room(a: Array) -> Array:
    wide = np.zeros((room(a.shape[0]), room(a.shape[1])))
    wide[: a.shape[0], : a.shape[1]] = a
    return wide


def step_of(a: Array, step: float, ramped: bool = True) -> tuple[Array, Array, Array]:
    n = len(a)
    ladder, _ = ladder_of(a, step, ramped)
    change, integral, ramp = ladder[0, :, :n, :n]
    return change, integral, ramp


def ladder_of(a: Array, step: float, ramped: bool = True) -> tuple[Array, int]:
    n = len(a)
    ladder, term, work = np.full((HALVES + 1, 3, room(n), room(n)), 7.0), *np.full((2, room(n), room(n)), 7.0)
    return ladder, transition(with_room(a), n, step, ramped, ladder, term, work)


@pytest.mark.parametrize("size", [1e-3, 1.0, 50.0, 2e4])
@pytest.mark.parametrize("n", [1, 6, 8, 13])
@pytest.mark.parametrize("seed", range(3))
def test_change_and_integrals_are_those_of_the_exponential(size: float, n: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    step = 1e-3
    a = size * rng.normal(size=(n, n)) - 2.0 * size * np.eye(n)
    change, integral, ramp = step_of(a, step)
    wide = np.zeros((3 * n, 3 * n))  # Van Loan 1978: the integrals are blocks of one exponential
    wide[:n, :n], wide[:n, n : 2 * n], wide[n : 2 * n, 2 * n :] = a, np.eye(n), np.eye(n)
    whole = linalg.expm(wide * step)
    np.testing.assert_allclose(change + np.eye(n), whole[:n, :n], rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(integral, whole[:n, n : 2 * n], rtol=1e-9, atol=1e-10 * step)
    np.testing.assert_allclose(ramp, whole[:n, 2 * n :], rtol=1e-9, atol=1e-10 * step**2)


def test_without_the_ramp_the_rest_is_the_same() -> None:
    a = np.random.default_rng(2).normal(size=(5, 5))
    with_ramp, without = step_of(a, 3.0), step_of(a, 3.0, ramped=False)
    np.testing.assert_array_equal(without[0], with_ramp[0])
    np.testing.assert_array_equal(without[1], with_ramp[1])


@pytest.mark.parametrize("size", [1e-2, 50.0])
def test_halves_of_a_step_and_its_double(size: float) -> None:
    """They are what is asked for at once; a machine that is not stiff has no halves."""
    step, n = 0.1, 5
    a = size * np.random.default_rng(3).normal(size=(n, n)) - 2.0 * size * np.eye(n)
    ladder, many = ladder_of(a, step)
    assert (many > 0) == (size > 1.0)
    for i in range(many + 1):
        for half, expected in zip(ladder[i], step_of(a, step / 2.0**i), strict=True):
            np.testing.assert_allclose(half[:n, :n], expected, rtol=1e-9, atol=1e-12)
    twice = np.full_like(ladder[0], 7.0)
    double(ladder[0], twice, n, True)
    for found, expected in zip(twice, step_of(a, 2.0 * step), strict=True):
        np.testing.assert_allclose(found[:n, :n], expected, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize(("size", "pieces"), [(1.0, 1), (60.0, 5), (2000.0, 10)])
def test_what_a_source_that_goes_straight_between_moments_adds(size: float, pieces: int) -> None:
    """Against the exponential of each piece, its source and the slope of that as states of their own (Van Loan)."""
    rng, n, step = np.random.default_rng(4), 5, 0.1
    a = size * rng.normal(size=(n, n)) / n - size * np.eye(n)
    ladder, many = ladder_of(a, step)
    assert many + 1 == pieces
    nodes, use = np.full((HALVES + 2, room(n), room(n)), 7.0), [np.full((room(n), room(n)), 7.0) for _ in range(3)]
    source_weights(ladder, many, n, step, nodes, *use)
    moments = step * np.append(0.0, 0.5 ** np.arange(many, -1.0, -1.0))
    sources = rng.normal(size=(len(moments), n))
    x = np.zeros(n)
    for first, last, begin, end in zip(moments, moments[1:], sources, sources[1:], strict=False):
        wide = np.zeros((3 * n, 3 * n))  # d/dt [x, source, slope] = [a x + source, slope, 0]
        wide[:n, :n], wide[:n, n : 2 * n], wide[n : 2 * n, 2 * n :] = a, np.eye(n), np.eye(n)
        length = last - first
        x = (linalg.expm(wide * length) @ np.concatenate([x, begin, (end - begin) / length]))[:n]
    found = np.sum([node[:n, :n] @ source for node, source in zip(nodes, sources, strict=False)], axis=0)
    np.testing.assert_allclose(found, x, rtol=1e-7, atol=1e-9 * np.abs(x).max())


def test_more_halves_than_there_is_room_for() -> None:
    """A circuit that settles within a ten thousandth of a step, and drives a mass: steps as of two machines apart."""
    fast, step = 1e7, 1e-3
    ladder, many = ladder_of(np.array([[-fast, 0.0], [1.0, 0.0]]), step)
    assert many == HALVES
    change, integral, ramp = ladder[0, :, :2, :2]
    np.testing.assert_allclose(change, [[-1.0, 0.0], [1.0 / fast, 0.0]], rtol=1e-6, atol=1e-15)
    np.testing.assert_allclose(integral, [[1.0 / fast, 0.0], [step / fast, step]], rtol=2e-4, atol=1e-15)
    np.testing.assert_allclose(ramp[1], [0.5 * step**2 / fast, 0.5 * step**2], rtol=2.5e-4)


def test_a_singular_machine_drifts() -> None:
    """A mass without spring: position grows with speed."""
    change, integral, ramp = step_of(np.array([[0.0, 1.0], [0.0, 0.0]]), 0.5)
    np.testing.assert_allclose(ramp, [[0.125, 0.125 / 6.0], [0.0, 0.125]], atol=1e-15)
    np.testing.assert_allclose(change, [[0.0, 0.5], [0.0, 0.0]], atol=1e-15)
    np.testing.assert_allclose(integral, [[0.5, 0.125], [0.0, 0.5]], atol=1e-15)


@pytest.mark.parametrize("inner", [4, 5])
def test_product_of_rectangles(inner: int) -> None:
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(3, inner)), rng.normal(size=(inner, 4))
    out = np.zeros((room(3), room(4)))
    product(with_room(a), with_room(b), 3, inner, out)
    np.testing.assert_allclose(out[:3, :4], a @ b, rtol=1e-14)
