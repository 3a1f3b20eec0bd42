"""Hidden states driven by a motion: against closed forms of Dahl's law."""

from __future__ import annotations

import numpy as np
import pytest

from symdyn.compiler import compile_robot
from symdyn.emit.kernel import Kernel
from symdyn.numeric.memory import remembered
from symdyn.spec.edit import add_effect

from .pendulum import TOML, pendulum

STIFFNESS, LEVEL = 20.0, 0.4


@pytest.fixture(scope="module")
def kernel() -> Kernel:
    values = {"stiffness": f"{STIFFNESS} N m/rad", "level": f"{LEVEL} N m"}
    return compile_robot(pendulum(add_effect(TOML, "dahl_friction", "arm", values))).kernel()


def along(kernel: Kernel, time: np.ndarray, speed: float, parts: tuple[slice, ...] = ()) -> np.ndarray:
    q, qd = (speed * time)[:, None], np.full((len(time), 1), speed)
    return remembered(kernel, q, qd, time, parts or (slice(0, len(time)),), kernel.values)[:, 0]


@pytest.mark.parametrize("speed", [0.01, -0.3, 500.0])
def test_friction_grows_with_the_distance_and_is_stable_at_any_speed(kernel: Kernel, speed: float) -> None:
    time = np.linspace(0.0, 2.0, 401)
    expected = -np.sign(speed) * LEVEL * (1.0 - np.exp(-STIFFNESS * np.abs(speed) * time / LEVEL))
    np.testing.assert_allclose(along(kernel, time, speed), expected, atol=1e-6)


def test_every_stretch_begins_from_nothing(kernel: Kernel) -> None:
    time = np.linspace(0.0, 2.0, 401)
    force = along(kernel, time, 0.01, (slice(0, 200), slice(200, 401)))
    np.testing.assert_allclose(force[200:], along(kernel, time[200:], 0.01), rtol=1e-12)
    assert force[200] == 0.0


def test_it_stays_where_nothing_moves(kernel: Kernel) -> None:
    time = np.linspace(0.0, 1.0, 101)
    speed = np.where(time < 0.5, 0.2, 0.0)
    force = remembered(kernel, np.zeros((101, 1)), speed[:, None], time, (slice(0, 101),), kernel.values)[:, 0]
    assert np.ptp(force[52:]) == 0.0
    assert force[-1] == pytest.approx(-LEVEL * (1.0 - np.exp(-STIFFNESS * 0.2 * 0.495 / LEVEL)), rel=1e-3)
