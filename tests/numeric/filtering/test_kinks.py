"""Steps across a kink: how far a machine goes on straight, and that what chatters is not followed for ever."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from symdyn.numeric.filtering.kinks import FIRST, HASTY, RUNGS, SHORTEST, reach, stiffen
from symdyn.numeric.transition import transition

STEP, WIDE = 1e-3, 8
FORCE, WIDTH = 1e6, 1e-3  # acceleration by friction, and the speed within which it turns


@njit
def rate(x: np.ndarray, u: np.ndarray, p: np.ndarray, out: np.ndarray) -> None:
    out[0] = u[0] - FORCE * np.tanh(x[0] / WIDTH)


@njit
def slope(x: np.ndarray, u: np.ndarray, p: np.ndarray, out: np.ndarray) -> None:
    out[0, 0] = -FORCE / WIDTH / np.cosh(x[0] / WIDTH) ** 2


def reached(speed: float, left: float, shortest: float) -> tuple[float, float, float]:
    """How far from there, by how much a speed changes on the way (less 1), and the slope that this was made with."""
    x, u, p = np.array([speed]), np.array([10.0]), np.zeros(1)
    here, by_x = np.zeros(1), np.zeros((1, 1))
    rate(x, u, p, here)
    a = np.zeros((WIDE, WIDE))
    slope(x, u, p, by_x)
    a[0, 0], a[0, 1] = by_x[0, 0], 1.0
    ladder, term, space = np.zeros((RUNGS, 3, WIDE, WIDE)), *np.zeros((2, WIDE, WIDE))
    part, rung = reach(
        rate, slope, x, u, np.zeros(1), p, here, np.zeros(1), a, 2, STEP, left, shortest, False, ladder, -1,
        np.array([FORCE]), np.zeros(1), np.zeros(1), np.zeros(1), by_x, term, space,
    )  # fmt: skip
    assert part == left * 0.5**rung
    return part, float(ladder[rung, 0, 0, 0]), float(a[0, 0])


@pytest.mark.parametrize("shortest", [SHORTEST, HASTY])
def test_far_from_the_kink_a_step_goes_on_whole(shortest: float) -> None:
    assert reached(1e5, 1.0, shortest)[0] == 1.0


def test_across_the_kink_pieces_are_short_unless_there_were_many() -> None:
    """Just above where friction turns: the next microsecond throws the body across."""
    assert reached(0.5, 1.0, SHORTEST)[0] == SHORTEST
    part, change, made_with = reached(0.5, 1.0, HASTY)
    assert part == HASTY
    assert made_with < 0.0  # the secant holds it there
    assert change == pytest.approx(np.expm1(made_with * STEP * part), rel=1e-9)


@pytest.mark.parametrize("pieces", [5.0, 60.0])
def test_before_the_kink_pieces_are_as_long_as_the_way_there(pieces: float) -> None:
    """A body that friction brings to rest after that many of the shortest pieces, of which 16 are tried first."""
    part, change, _ = reached(FORCE * STEP * SHORTEST * pieces, 1.0, SHORTEST)
    assert 0.25 * pieces < part / SHORTEST < 2.0 * pieces
    assert change == 0.0
    assert (part < FIRST) == (pieces < 16.0)


def test_no_piece_is_longer_than_what_is_left() -> None:
    left = 5.0 * SHORTEST
    assert reached(0.5, left, HASTY)[0] == left
    assert reached(0.5, left, SHORTEST)[0] == 1.25 * SHORTEST


def test_what_stands_when_a_force_hits_it_goes_on() -> None:
    """Held by friction to the last digit, it has no speed for a secant: that of nothing would be without a limit."""
    a, h = np.zeros((WIDE, WIDE)), STEP * SHORTEST
    still, none = np.zeros(1), np.zeros(1)
    stiffen(a, still, np.array([1e-300]), np.zeros(1), np.array([-FORCE]), none, none, h)
    assert a[0, 0] < 0.0
    ladder, term, space = np.zeros((RUNGS, 3, WIDE, WIDE)), *np.zeros((2, WIDE, WIDE))
    transition(a, 1, h, False, ladder, term, space)
    assert ladder[0, 0, 0, 0] == pytest.approx(-1.0)  # it is at its end at once
