"""How much of an error the sensors' noise accounts for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.numeric.filtering.signals import Signals
from symdyn.numeric.filtering.twists import with_twists
from symdyn.numeric.filtering.windows import noise_alone, off, sizes, white_noise

STEP, COUNT = 0.001, 20000


def signals(y: NDArray[np.float64], floor: float = 0.0, gap: int = 0) -> Signals:
    steps = np.full(len(y), STEP)
    steps[-1] = np.nan
    if gap:
        steps[gap] = np.nan
    time = STEP * np.arange(len(y))
    empty = np.zeros((len(y), 0))
    return Signals(time, empty, y[:, None], np.zeros(1, np.int64), ("q",), steps, np.array([floor]), *np.ones((2, 1)))


def moving() -> NDArray[np.float64]:
    return np.sin(2.0 * np.pi * 2.0 * STEP * np.arange(COUNT))


def test_white_noise_is_told_from_motion() -> None:
    noise = np.random.default_rng(1).normal(0.0, 1e-3, COUNT)
    assert white_noise(signals(moving() + noise)) == pytest.approx(1e-6, rel=0.05)


def test_what_a_filter_calls_noise_is_none_where_it_is_slow() -> None:
    """A twist of a tenth between two encoders: a filter of a rigid model has no other name for it."""
    own = signals(moving())
    assert noise_alone(own, np.array([0.01])) < 1e-4
    assert noise_alone(own, np.array([1e-20])) == pytest.approx(1e-10 / sizes(own))


def test_a_gap_is_no_noise() -> None:
    parted = moving()
    parted[COUNT // 2 + 1 :] += 3.0
    assert white_noise(signals(parted, gap=COUNT // 2)) < 1e-10
    assert white_noise(signals(parted)) > 1e-5


def test_an_encoder_that_seldom_steps_is_no_better_than_its_steps() -> None:
    step = 0.5
    slow = step * np.round(moving() / step)
    assert white_noise(signals(slow, floor=step**2 / 12.0)) >= step**2 / 12.0


def of_a_drive(twist: float, noise: float, seed: int) -> Signals:
    """Encoders on both sides of a gear of 5, its soft shaft twisting at 3 Hz; then a current."""
    rng = np.random.default_rng(seed)
    bent = twist * np.sin(2.0 * np.pi * 3.0 * STEP * np.arange(COUNT))
    shown = np.column_stack([5.0 * (moving() + bent), moving()]) + rng.normal(0.0, noise, (COUNT, 2))
    y = np.column_stack([shown, rng.normal(0.0, 1.0, COUNT)])
    names, turns = ("arm.motor.q", "arm.q", "arm.circuit.current"), np.array([5.0, 1.0])
    index = np.array([0, 1, 4])
    return replace(signals(y[:, 0]), y=y, index=index, names=names, floor=np.zeros(3), per_joint=turns, speeds=turns)


def test_a_twist_that_encoders_show_is_judged_beside_them() -> None:
    first, second = with_twists(of_a_drive(1e-3, 1e-6, 1), of_a_drive(2e-3, 1e-6, 2))
    assert first.judged == ("arm.motor.q", "arm.q", "arm.circuit.current", "arm.motor.q - arm.q")
    assert second.judged == first.judged
    predicted = first.y.copy()
    predicted[:, 0] = 5.0 * moving()  # of a rigid drive: off by a thousandth of the motion, and by all of the twist
    error = np.sqrt(np.mean(off(first, predicted) ** 2, axis=0))
    assert error[0] < 3e-3
    assert error[3] == pytest.approx(np.sqrt(0.5) * 1e-3 / sizes(first)[3], rel=1e-2)
    assert noise_alone(first, np.array([1e-12, 1e-12, 1.0]))[3] == pytest.approx(np.sqrt(1.04e-12) / sizes(first)[3])


def test_a_twist_below_the_noise_of_its_encoders_is_none() -> None:
    first, second = with_twists(of_a_drive(1e-3, 1e-6, 1), of_a_drive(1e-5, 1e-5, 2))
    assert first.judged == second.judged == first.names
