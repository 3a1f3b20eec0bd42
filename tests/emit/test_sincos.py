"""The sine and cosine that kernels carry, against the mathematical ones."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mpmath import mp
from numba import njit

from symdyn.compiler import compile_robot, load_robot

Pair = Callable[[float], tuple[float, float]]


@pytest.fixture(scope="module", params=["alone", "second of two", "third of eight", "ninth of ten"])
def sincos(request: pytest.FixtureRequest) -> Pair:
    """Of one angle by itself, and of one among others, which fill vectors of 2 and 8, or of 8 and 2."""
    module = compile_robot(load_robot("two-link")).kernel().module
    apart, together = module._apart, module._together

    @njit
    def alone(x: float) -> Any:
        return apart((x,))

    @njit
    def of_two(x: float) -> Any:
        return together((math.nan, x))[2:4]

    @njit
    def of_eight(x: float) -> Any:
        return together((1.0, -2e6, x, math.inf, 0.0, 2.0, -3.0, 4.0))[4:6]

    @njit
    def of_ten(x: float) -> Any:
        return together((1.0, -2e6, 1.5, math.inf, 0.0, 2.0, -3.0, 4.0, x, 5.0))[16:18]

    forms: dict[str, Pair] = {
        "alone": alone,
        "second of two": of_two,
        "third of eight": of_eight,
        "ninth of ten": of_ten,
    }
    return forms[request.param]


def exact(x: float) -> tuple[float, float]:
    with mp.workdps(40):
        return float(mp.sin(mp.mpf(x))), float(mp.cos(mp.mpf(x)))


@pytest.mark.parametrize("size", [1.0, 100.0, 1e4, 1e6])
def test_exact_to_the_last_digits_within_a_million_radians(sincos: Pair, size: float) -> None:
    rng = np.random.default_rng(1)
    worst = max(
        abs(found - wanted)
        for x in rng.uniform(-size, size, 2000).tolist()
        for found, wanted in zip(sincos(x), exact(x), strict=True)
    )
    assert worst < 2.3e-16


def test_exact_at_multiples_of_a_right_angle(sincos: Pair) -> None:
    for n in range(-2000, 2001):
        x = n * math.pi / 2  # the double nearest to it: its sine is not 0, and is known to the last digit
        for found, wanted in zip(sincos(x), exact(x), strict=True):
            assert abs(found - wanted) < 2.3e-16


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], deadline=None)
@given(x=st.floats(1e6, 0.9e15))
def test_beyond_it_is_as_exact_as_the_angle(sincos: Pair, x: float) -> None:
    sine, cosine = sincos(x)
    assert abs(sine) <= 1.0 + 1e-9
    assert abs(cosine) <= 1.0 + 1e-9
    for found, wanted in zip((sine, cosine), exact(x), strict=True):
        assert abs(found - wanted) < 2.0 * math.ulp(x)


@pytest.mark.parametrize("x", [math.nan, math.inf, -math.inf, 1e15, -1e300])
def test_no_angle_gives_no_number(sincos: Pair, x: float) -> None:
    assert all(math.isnan(value) for value in sincos(x))


def test_zero(sincos: Pair) -> None:
    assert sincos(0.0) == (0.0, 1.0)


def test_odd_and_even(sincos: Pair) -> None:
    for x in np.random.default_rng(2).uniform(0, 50, 200).tolist():
        sine, cosine = sincos(x)
        assert sincos(-x) == (-sine, cosine)


@pytest.mark.parametrize("size", [3.0, 1e6])
def test_compiled_in_blocks_it_is_the_same(size: float) -> None:
    """Fused products and sums may move the last digit of an intermediate, no more."""
    kernel = compile_robot(load_robot("two-link")).kernel()
    rng = np.random.default_rng(3)
    q = rng.uniform(-size, size, (67, 2))
    rows = kernel.gravity_batch(q)
    wanted = np.array([[math.cos(a), math.cos(a + b)] for a, b in q])
    g, l1, m1, m2, r1, r2 = 9.81, 0.5, 1.08, 0.864, 0.25, 0.2
    shoulder = (m1 * r1 + m2 * l1) * g * wanted[:, 0] + m2 * r2 * g * wanted[:, 1]
    # a + b is rounded in the reference, and is not in the kernel
    np.testing.assert_allclose(rows[:, 0], shoulder, atol=20 * np.spacing(size) + 1e-14)
