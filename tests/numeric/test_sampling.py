"""Coarse samples of a complete model: what lies between them is no physics that is missing."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.compiler import compile_robot, robot_from_text
from symdyn.numeric.beyond_noise import left_by_positions
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.explanation import Case
from symdyn.numeric.findings import Verdict
from symdyn.numeric.observation import observe
from symdyn.numeric.recording import Recording
from symdyn.numeric.sampling import left_at, left_by_derivatives, left_by_sampling
from symdyn.numeric.setting import prepare
from symdyn.numeric.workbench import Workbench

from .pendulum import recording

Array = NDArray[np.float64]

TURNING, VISCOUS, DRY, WEIGHT = 0.05, 0.1, 0.4, 1.2  # kg m^2, N m s/rad, N m, N m
STEP = 1e-4
MODEL = """[robot]
name = "arm"
gravity = [0, "-9.81 m/s^2", 0]

[[joint]]
name = "arm"
placement = { xyz = [0, 0, 0] }
link = { mass = "0.5 kg", com = [0, "-0.2 m", 0], inertia = { zz = "0.02 kg m^2" } }

[[effect]]
type = "viscous_friction"
at = "arm"
coefficient = "0.13 N m s/rad"

[[effect]]
type = "coulomb_friction"
at = "arm"
level = "0.5 N m"
"""


@cache
def sampled(seed: int, rate: int, dry: float = DRY) -> Recording:
    """Dry friction that holds the arm exactly where it can, under a servo whose torque is held over each sample."""
    rng = np.random.default_rng(seed)
    frequency = 0.1 * np.arange(1, 15)
    phase = rng.uniform(0.0, 2.0 * np.pi, len(frequency))
    size = 0.8 / (1.0 + (frequency / 0.8) ** 2) * rng.uniform(0.5, 1.5, len(frequency))
    time = np.arange(20 * rate) / rate
    angle = 2.0 * np.pi * np.outer(time, frequency) + phase
    wanted, speed = np.sin(angle) @ size, np.cos(angle) @ (2.0 * np.pi * frequency * size)
    q, v, shown, held = float(wanted[0]), float(speed[0]), [], []
    for k in range(len(time)):
        torque = 9.0 * (wanted[k] - q) + 1.2 * (speed[k] - v)
        shown.append(q)
        held.append(torque)
        for _ in range(round(1.0 / rate / STEP)):
            free = v + STEP * (torque - VISCOUS * v - WEIGHT * np.sin(q)) / TURNING
            slowed = np.sign(free) * max(abs(free) - STEP * dry / TURNING, 0.0)
            q, v = q + STEP * (v + slowed) / 2.0, slowed
    noise = rng.standard_normal((2, len(time)))
    return recording(time, np.array(shown) + 1e-5 * noise[0], np.array(held) + 2e-3 * noise[1])


def case_of(rate: int, dry: float) -> Case:
    robot = robot_from_text(MODEL, "arm.toml")
    setting = prepare(robot, sampled(1, rate, dry), sampled(2, rate, dry), lambda _: None)
    return setting.earlier(-0.5 / rate).case(12.0)


@pytest.mark.parametrize("rate", [50, pytest.param(100, marks=pytest.mark.slow)])
def test_coarse_samples_of_a_complete_model_show_nothing_missing(rate: int) -> None:
    told = diagnose(robot_from_text(MODEL, "arm.toml"), sampled(1, rate), sampled(2, rate))
    assert (told.verdict, told.findings) == (Verdict.COMPLETE, ())


@pytest.mark.parametrize("rate", [50, 100, 200])
def test_what_samples_do_not_show_is_as_large_as_what_they_leave(rate: int) -> None:
    """The model has all that there is: what is left is that, and noise of a tenth of a per cent."""
    case = case_of(rate, DRY)
    explained = case.explain()
    left, expected = (
        float(np.sqrt(np.mean(each**2))) for each in (explained.heldout, case.left_by_sampling(explained))
    )
    assert 0.4 * left < expected < 1.5 * left


def test_without_dry_friction_little_is_between_samples() -> None:
    smooth, dry = case_of(100, 0.0), case_of(100, DRY)
    sizes = []
    for case in (smooth, dry):
        explained = case.explain()
        of = left_by_sampling(case.judged, (), (), explained.fit.p)
        sizes.append(float(np.sqrt(np.mean(of**2))))
    assert sizes[0] < 0.3 * sizes[1]


def taken(q: Array) -> Workbench:
    """The arm of which these positions were taken (N,) at 200 Hz; every derivative is looked at."""
    time = np.arange(len(q)) / 200.0
    robot = robot_from_text(MODEL, "arm.toml")
    kernel = compile_robot(robot).kernel()
    return Workbench(kernel, observe(robot, kernel, recording(time, q, 0.0 * q), cutoff=1e9), planned=True)


@pytest.mark.parametrize("turn", [0.3, 0.6, 0.9])
def test_what_derivatives_leave_of_a_motion_is_told_by_wider_ones(turn: float) -> None:
    """``turn`` radians per sample: what they are off by, within a third."""
    bench = taken(np.sin(turn * np.arange(4000)))
    inner = slice(10, -10)  # the ends have fewer samples
    told = left_by_derivatives(bench, bench.kernel.values)[inner]
    o = bench.observation
    inertia = bench.kernel.rows("mass_matrix_p", o.q, bench.kernel.values)[0, 0, 0]
    true = inertia * (o.qdd + (turn * o.rate) ** 2 * o.q)[inner]
    assert 0.66 * np.std(true) < np.std(told) < np.std(true)
    share = inertia * (turn * o.rate) ** 2 * float(left_at(np.array(turn))) * np.std(o.q)
    assert np.std(told) == pytest.approx(share, rel=1e-3)


def test_what_derivatives_leave_of_noise_is_told_by_its_level() -> None:
    bench = taken(1e-5 * np.random.default_rng(3).standard_normal(20000))
    p = bench.kernel.values
    left = np.std(left_by_derivatives(bench, p))
    assert left == pytest.approx(left_by_positions(bench, p, left_at)[0], rel=0.1)
    assert left < 0.5 * left_by_positions(bench, p)[0]
