"""Steps across a kink: how far a machine goes on straight, and that what chatters is not followed for ever."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from symdyn.numeric.filtering.kinks import FINEST, HASTY, RUNGS, reach
from symdyn.numeric.transition import HALVES

STEP, WIDE = 1e-3, 8
FORCE, WIDTH = 1e6, 1e-3  # acceleration by friction, and the speed within which it turns


@njit
def rate(x: np.ndarray, u: np.ndarray, p: np.ndarray, out: np.ndarray) -> None:
    out[0] = u[0] - FORCE * np.tanh(x[0] / WIDTH)


@njit
def slope(x: np.ndarray, u: np.ndarray, p: np.ndarray, out: np.ndarray) -> None:
    out[0, 0] = -FORCE / WIDTH / np.cosh(x[0] / WIDTH) ** 2


def reached(speed: float, left: int, first: int) -> tuple[int, float, float]:
    """How far from there, by how much a speed changes on the way (less 1), and the slope that this was made with."""
    x, u, p = np.array([speed]), np.array([10.0]), np.zeros(1)
    here, by_x = np.zeros(1), np.zeros((1, 1))
    rate(x, u, p, here)
    a = np.zeros((WIDE, WIDE))
    slope(x, u, p, by_x)
    a[0, 0], a[0, 1] = by_x[0, 0], 1.0
    ladder, halves = np.zeros((RUNGS, 3, WIDE, WIDE)), np.zeros((HALVES, 3, WIDE, WIDE))
    change, integral, ramp, term, space = (np.zeros((WIDE, WIDE)) for _ in range(5))
    length, _ = reach(
        rate, slope, x, u, np.zeros(1), p, here, np.zeros(1), a, 2, STEP, left, False, ladder, 0, change, integral,
        ramp, np.array([FORCE]), np.zeros(1), np.zeros(1), np.zeros(1), by_x, term, space, halves, first,
    )  # fmt: skip
    return length, float(change[0, 0]), float(a[0, 0])


@pytest.mark.parametrize("first", [0, HASTY])
def test_far_from_the_kink_a_step_goes_on_whole(first: int) -> None:
    assert reached(1e5, FINEST, first)[0] == FINEST


def test_across_the_kink_pieces_are_short_unless_there_were_many() -> None:
    """Just above where friction turns: the next microsecond throws the body across."""
    assert reached(0.5, FINEST, 0)[0] == 1
    length, change, made_with = reached(0.5, FINEST, HASTY)
    assert length == 2**HASTY
    assert made_with < 0.0  # the secant holds it there
    assert change == pytest.approx(np.expm1(made_with * STEP * length / FINEST), rel=1e-9)


def test_no_piece_is_longer_than_what_is_left() -> None:
    assert reached(0.5, 5, HASTY)[0] <= 5
