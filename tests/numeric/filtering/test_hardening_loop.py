"""An oscillator whose spring has a loop that stiffens as it loads: without a level that its force would keep to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot
from tests.numeric.filtering.oscillator import DAMPING, MASS, MODEL, RATE, SPRING

ALPHA, BETA, GAMMA = 5e4, 800.0, -1100.0  # dz/dt = alpha v - beta |v| z - gamma v |z|
SAMPLES, WITHIN = 3000, 64
NOISE = 8e-6  # m


def record(path: Path, robot: Robot, seed: int) -> Recording:
    """Random phases from 5 to 60 Hz, 50 N rms, held over each sample, in steady state."""
    random = np.random.default_rng(seed)
    hertz = np.arange(SAMPLES // 2 + 1) * RATE / SAMPLES
    waves = np.where((hertz >= 5.0) & (hertz <= 60.0), np.exp(2j * np.pi * random.random(len(hertz))), 0.0)
    force = np.fft.irfft(waves)
    force *= 50.0 / force.std()
    x = v = z = 0.0
    h, shown = 1.0 / RATE / WITHIN, []
    for f in [*force.tolist(), *force.tolist()]:
        shown.append(x)
        for _ in range(WITHIN):
            v += h * (f - DAMPING * v - SPRING * x - z) / MASS
            x += h * v
            z += h * (ALPHA * v - BETA * abs(v) * z - GAMMA * v * abs(z))
    seen = np.array(shown[SAMPLES:]) + NOISE * random.standard_normal(SAMPLES)
    rows = np.column_stack([np.arange(SAMPLES) / RATE, force, seen])
    np.savetxt(path, rows, delimiter=",", header="t,f,x", comments="", fmt="%.9g")
    return read_recording(path, robot.channels)


@pytest.mark.slow  # a whole diagnosis
def test_a_loop_that_stiffens_as_it_loads_is_told_with_its_numbers(tmp_path: Path) -> None:
    robot = robot_from_text(MODEL, "oscillator.toml")
    found = diagnose(robot, record(tmp_path / "a.csv", robot, 1), record(tmp_path / "b.csv", robot, 2))
    assert [(f.effect, f.place) for f in found.findings] == [("hardening_hysteresis", "mass")]
    told = found.findings[0].parameters
    # beta + gamma = -1/D, beta = (r - 1) / 2 D
    for name, value in {"stiffness": ALPHA, "displacement": 1 / 300, "ratio": 1.0 + 2.0 * 800.0 / 300.0}.items():
        se = told[name].se
        assert se is not None
        assert abs(told[name].value - value) < 3.0 * se < 0.2 * value, name
    assert found.noise_floor is not None
    assert found.after.heldout < 1.3 * found.noise_floor.errors.heldout
    assert not found.remaining.structured
