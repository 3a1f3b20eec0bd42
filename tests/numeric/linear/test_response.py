"""Frequency responses against python-control, fifty digits and closed forms."""

from __future__ import annotations

import time

import mpmath
import numpy as np
import pytest

from symdyn.base.errors import UsageError
from symdyn.base.linear_system import LinearSystem
from symdyn.numeric.linear.drops import without
from symdyn.numeric.linear.resolvent import Resolvent, laplace
from symdyn.numeric.linear.response import extrema, frequency_response
from symdyn.numeric.linear.signals import as_control, channel, grid, short_names
from symdyn.numeric.linear.transfer import transfer_function

from .machines import chain, drive

HERTZ = np.geomspace(0.1, 3000, 2000)


def exact(system: LinearSystem, hertz: float, row: np.ndarray, k: int) -> complex:
    """In fifty digits."""
    with mpmath.workdps(50):
        s = 2j * mpmath.pi * mpmath.mpf(hertz)
        n = len(system.states)
        matrix = mpmath.matrix(n, n)
        for i in range(n):
            for j in range(n):
                matrix[i, j] = s * mpmath.mpf(system.e[i, j]) - mpmath.mpf(system.f[i, j])
        x = mpmath.lu_solve(matrix, mpmath.matrix([mpmath.mpf(v) for v in system.h[:, k]]))
        return complex(sum(mpmath.mpf(row[i]) * x[i] for i in range(n)))


def test_against_python_control() -> None:
    system = drive().nominal
    theirs = as_control(system)(2j * np.pi * HERTZ, squeeze=False)[0, 0]
    ours = frequency_response(system, HERTZ).values
    assert np.abs(ours / theirs - 1).max() < 1e-10


@pytest.mark.parametrize("output", ["axis1.tachometer.voltage", "axis1.qd", "axis1.motor.current", "axis1.motor.q"])
def test_against_fifty_digits(output: str) -> None:
    system = drive().nominal
    hertz = np.array([0.1, 9.8806, 15.46, 100.0, 395.05, 628.4, 945.5, 3000.0])
    chosen = channel(system, None, output)
    expected = [exact(system, f, chosen.row, chosen.k) for f in hertz]
    got = frequency_response(system, hertz, "axis1.motor.voltage", output).values
    assert np.abs(got / np.array(expected) - 1).max() < 1e-10


def test_twenty_thousand_points_take_less_than_fifty_milliseconds() -> None:
    system, hertz = drive().nominal, np.geomspace(0.1, 3000, 20_000)
    frequency_response(system, hertz)
    took = []
    for _ in range(5):
        start = time.thread_time()
        frequency_response(system, hertz)
        took.append(time.thread_time() - start)
    assert min(took) < 0.05


def test_left_and_right_solutions_agree() -> None:
    system = drive().nominal
    resolvent, s = Resolvent.of(system), laplace(HERTZ[::40])
    x, y = resolvent.right(s, system.h[:, 0]), resolvent.left(s, system.c[0])
    assert np.abs((y * system.h[:, :1]).sum(axis=0) / (system.c[0] @ x) - 1).max() < 1e-9


def test_without_inductance_the_response_is_that_of_the_limit() -> None:
    """E is singular there; L = 1e-12 H comes near."""
    family = drive()
    p = family.values.copy()
    p[family.index("L")] = 1e-12
    limit = without(family, "L")
    assert limit is not None
    got = frequency_response(limit, HERTZ).values
    near = frequency_response(family.at(p), HERTZ).values
    assert np.abs(got / near - 1).max() < 1e-7


def test_peaks_and_anti_resonances_of_the_seed() -> None:
    found = extrema(drive().nominal, 5.0, 3000.0)
    peaks = [e.frequency for e in found if e.kind == "peak"]
    assert peaks == pytest.approx([15.46, 628.4, 1221.7], rel=4e-4)
    assert [e.frequency for e in found if e.kind != "peak"] == pytest.approx([9.88, 395.0, 945.5], rel=6e-4)


def test_a_two_mass_oscillator_in_closed_form() -> None:
    """Effort on the load of two free inertias: the joint's angle is (J_1 s^2 + d s + c) / (s^2 (...))."""
    j1, j2, c, d = 2e-3, 5e-3, 40.0, 0.01
    system = chain([j1, j2], [c], [d]).nominal
    s = 2j * np.pi * HERTZ
    expected = (j1 * s**2 + d * s + c) / ((j1 * s**2 + d * s + c) * (j2 * s**2 + d * s + c) - (d * s + c) ** 2)
    got = frequency_response(system, HERTZ, "load.effort", "load.q")
    assert np.abs(got.values / expected - 1).max() < 1e-9
    assert got.unit == "rad / (N m)"
    light = chain([j1, j2], [c], [d / 100]).nominal
    (zero,) = (e for e in extrema(light, 1, 100, None, "load.q") if e.kind == "anti-resonance")
    assert zero.frequency == pytest.approx(np.sqrt(c / j1) / (2 * np.pi), rel=1e-6)


def test_zeros_poles_and_gain_give_the_response_back() -> None:
    system = drive().nominal
    for output in (None, "axis1.q", "axis1.motor.current"):
        g = transfer_function(system, None, output)
        s = 2j * np.pi * HERTZ[:, None]
        value = g.gain * np.prod(s - g.zeros, axis=1) / np.prod(s - g.poles, axis=1)
        assert np.abs(value / frequency_response(system, HERTZ, None, output).values - 1).max() < 1e-6
    seen = transfer_function(system)
    assert len(seen.poles) == 8  # the tachometer does not see the angle
    assert np.sort_complex(seen.as_control().poles()) == pytest.approx(np.sort_complex(seen.poles), rel=1e-6)
    load = transfer_function(system, None, "axis1.qd")
    assert np.min(np.abs(load.zeros + 1.44 / 1600e-6)) < 1e-6  # -c_3 / d_3: the flexspline passes nothing there


def test_names() -> None:
    system = drive().nominal
    for bad in ({"input": "axis1.voltage"}, {"output": "axis1.motor.position"}):
        with pytest.raises(UsageError, match="SD305"):
            frequency_response(system, HERTZ, **bad)
    assert short_names(("a.motor", "b.motor", "a.drive")) == ("a.motor", "b.motor", "drive")
    for low, high in ((0.0, 1.0), (2.0, 1.0), (1.0, np.inf), (np.nan, 1.0)):
        with pytest.raises(UsageError, match="SD302"):
            grid(low, high, 10)


def test_python_control_gets_the_names() -> None:
    system = as_control(drive().nominal)
    assert system.output_labels == ["axis1_tachometer_voltage"]
    assert system.input_labels == ["axis1_motor_voltage"]
    assert system.state_labels[-1] == "axis1_motor_current"
    every = as_control(chain([1e-3, 1e-3], [1.0], [0.0]).nominal)
    assert every.output_labels == ["load_r1_q_", "load_q_", "load_r1_qd_", "load_qd_"]
