"""What is left where noise of the recorded force does the work of a law: it follows the motion all the same."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.compiler import robot_from_text
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.conclude import left_over, noise_floor
from symdyn.numeric.filtering.judged import Explanation, explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import Model, prepare, without_latent
from symdyn.numeric.findings import Errors
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

MODEL = """
[robot]
name = "mount"
gravity = [0, 0, 0]
[parameters]
m = "2 kg"
k = "1e5 N/m"
b = "10 N s/m"
[[joint]]
name = "mass"
kind = "prismatic"
placement = { }
link = { mass = "m" }
[[effect]]
type = "linear_spring"
at = "mass"
stiffness = "k"
[[effect]]
type = "viscous_friction"
at = "mass"
coefficient = "b"
[recording]
time = { column = "t", unit = "s" }
[[recording.channel]]
column = "u"
quantity = "effort"
joint = "mass"
unit = "N"
[[recording.channel]]
column = "y"
quantity = "position"
joint = "mass"
unit = "m"
"""
M, K, B = 2.0, 1e5, 10.0
RATE, COUNT, FINE = 750.0, 3000, 10
SENSOR = 2e-6  # m


def record(path: Path, robot: Robot, seed: int, hysteretic: float, gusts: float) -> Recording:
    """A mass on a spring, ``hysteretic`` (N/m) of it with hysteresis; ``gusts`` (N) beside the recorded force.

    It stiffens when it is loaded (Wen 1976, beta + gamma < 0) as no law of the catalogue does. Runge and Kutta's rule.
    """
    rng = np.random.default_rng(seed)
    time = np.arange(COUNT) / RATE
    spectrum = np.zeros(COUNT // 2 + 1, dtype=complex)
    band = slice(math.ceil(5.0 * COUNT / RATE), round(150.0 * COUNT / RATE))
    spectrum[band] = np.exp(1j * rng.uniform(0.0, 2.0 * np.pi, len(spectrum[band])))
    u = np.fft.irfft(spectrum, COUNT)
    u *= 50.0 / u.std()
    pushed = u + gusts * rng.normal(size=COUNT)
    state, h, y = np.zeros(3), 1.0 / RATE / FINE, np.zeros(COUNT)

    def rate(state: Array, force: float) -> Array:
        x, v, z = state
        bends = hysteretic * v - 1e3 * (0.8 * abs(v) * z - 1.1 * v * abs(z)) if hysteretic else 0.0
        return np.array([v, (force - B * v - (K - hysteretic) * x - z) / M, bends])

    for i in range(COUNT - 1):
        y[i] = state[0]
        for j in range(FINE):
            force = pushed[i] + (pushed[i + 1] - pushed[i]) * (j + 0.5) / FINE
            one = rate(state, force)
            two = rate(state + 0.5 * h * one, force)
            three = rate(state + 0.5 * h * two, force)
            state = state + h / 6.0 * (one + 2.0 * two + 2.0 * three + rate(state + h * three, force))
    y[-1] = state[0]
    rows = np.column_stack([time, u, y + SENSOR * rng.normal(size=COUNT)])
    np.savetxt(path, rows, delimiter=",", header="t,u,y", comments="", fmt="%.10g")
    assert robot.channels is not None
    return read_recording(path, robot.channels)


def as_it_is(tmp_path: Path, hysteretic: float, gusts: float) -> tuple[Model, Explanation]:
    """The model as given, fitted with noise of its input and without any unknown force."""
    robot = robot_from_text(MODEL, "mount.toml")
    runs = [record(tmp_path / f"{seed}.csv", robot, seed, hysteretic, gusts) for seed in (1, 2)]
    model = prepare(robot, runs[0], runs[1], only=("",))
    bench = model.bench(model.training, without_latent(model, model.training), Between.STRAIGHT)
    return model, explained(model, (), model.beliefs, fit(bench, model.values, model.beliefs))


@pytest.mark.parametrize(("hysteretic", "gusts", "follows"), [(5e4, 0.0, True), (0.0, 2.0, False)])
def test_what_noise_of_an_input_takes_up_is_told_where_it_follows_the_motion(
    tmp_path: Path, hysteretic: float, gusts: float, follows: bool
) -> None:
    model, final = as_it_is(tmp_path, hysteretic, gusts)
    assert final.fit.bench.noise.power[0] > 100.0 * final.fit.bench.noise.first[0]  # it did that work
    left = left_over(model, final, Errors(final.heldout, final.heldout), noise_floor(model, final.fit))
    assert left.structured is follows
    assert (left.place == "mass" and left.share > 0.5) if follows else left.place is None
