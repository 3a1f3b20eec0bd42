"""A motor and a load, both measured, that turn many times while the shaft between them hardly twists."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Diagnosis, Verdict
from symdyn.numeric.recording import read_recording

Array = NDArray[np.float64]

MODEL = """
[robot]
name = "two-mass"
gravity = [0, 0, 0]

[parameters]
J_m = "1.7e-3 kg m^2"
J_l = "6.5e-3 kg m^2"
k = "320 N m/rad"
d = "0.05 N m s/rad"
b_m = "0.009 N m s/rad"
b_l = "0.026 N m s/rad"

[dh]
rows = [ [ "q", 0, 0, 0 ] ]

[[joint]]
name = "load"
link = { inertia = { about = "joint", zz = "J_l" } }

[joint.drive]
ratio = 1
rotors = [ { name = "motor", inertia = "J_m" } ]
shafts = [ { name = "shaft", from = "motor", to = "joint", stiffness = "k", damping = "d" } ]
effort_at = "motor"

[[effect]]
type = "viscous_friction"
at = "load.motor"
coefficient = "b_m"

[[effect]]
type = "viscous_friction"
at = "load"
coefficient = "b_l"

[recording]
time = { column = "t", unit = "s" }
[[recording.channel]]
column = "tau"
quantity = "effort"
joint = "load"
side = "motor"
unit = "N m"
[[recording.channel]]
column = "motor"
quantity = "position"
joint = "load"
side = "motor"
unit = "rad"
[[recording.channel]]
column = "load"
quantity = "position"
joint = "load"
unit = "rad"
"""
RATE, FINE, COUNT, TURN = 1000.0, 50, 5000, 2.0**16  # samples per s, steps in each, samples, counts per turn
CLEARANCE, DRY, CUBIC = 0.006, 0.25, 4e6  # what is concealed


@njit
def simulated(tau: Array, clearance: float, dry: float, cubic: float) -> Array:
    """(N, 2) angles of motor and load: symplectic Euler; a flank pushes, and never pulls."""
    x = v = y = w = 0.0
    h, shown = 1.0 / RATE / FINE, np.empty((len(tau), 2))
    for i in range(len(tau)):
        shown[i] = x, y
        for _ in range(FINE):
            twist = x - y
            bent = twist - min(max(twist, -clearance), clearance)
            force = 260.0 * bent + cubic * bent**3 + 0.06 * (v - w) if bent != 0.0 else 0.0
            force = max(force, 0.0) if bent > 0.0 else min(force, 0.0)
            v += h / 2.1e-3 * (tau[i] - 0.011 * v - force)
            w += h / 5.4e-3 * (force - 0.02 * w)
            w = np.sign(w) * max(abs(w) - h / 5.4e-3 * dry, 0.0)
            x += h * v
            y += h * w
    return shown


def diagnosed(folder: Path, *concealed: float) -> Diagnosis:
    robot, runs = robot_from_text(MODEL, "two-mass.toml"), []
    assert robot.channels is not None
    for seed in (1, 2):
        rng = np.random.default_rng(seed)
        time = np.arange(COUNT) / RATE
        frequencies = (1.0 + 0.05 * seed) * np.array([0.23, 0.61, 1.3, 2.7, 5.3, 11.0])
        phases, sizes = rng.uniform(0.0, 2.0 * np.pi, 6), rng.uniform(0.5, 1.0, 6)
        tau = 1.1 * np.sin(2.0 * np.pi * np.outer(time, frequencies) + phases) @ sizes
        angles = np.round(simulated(tau, *concealed) / (2.0 * np.pi / TURN)) * 2.0 * np.pi / TURN
        table = np.column_stack([time, tau + rng.normal(0.0, 4e-3, COUNT), angles])
        np.savetxt(folder / f"{seed}.csv", table, delimiter=",", header="t,tau,motor,load", comments="", fmt="%.9g")
        runs.append(read_recording(folder / f"{seed}.csv", robot.channels))
    return diagnose(robot, *runs)


@pytest.mark.slow
def test_play_of_a_third_of_a_degree_is_told_beside_many_turns(tmp_path: Path) -> None:
    """The load stands, held by its friction, as flanks hit it."""
    found = diagnosed(tmp_path, CLEARANCE, DRY, 0.0)
    assert found.verdict is Verdict.MISSING_PHYSICS
    told = {(f.effect, f.place): f.parameters for f in found.findings}
    assert set(told) == {("coulomb_friction", "load"), ("backlash", "load.shaft")}
    assert told["backlash", "load.shaft"]["clearance"].value == pytest.approx(CLEARANCE, rel=1e-3)
    assert told["coulomb_friction", "load"]["level"].value == pytest.approx(DRY, rel=1e-2)
    assert "load.motor.q - load.q" in found.per_joint


@pytest.mark.slow
def test_a_shaft_that_hardens_is_told_beside_many_turns(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, 0.0, DRY, CUBIC)
    told = {(f.effect, f.place): f.parameters for f in found.findings}
    assert set(told) == {("coulomb_friction", "load"), ("hardening_spring", "load.shaft")}
    assert told["hardening_spring", "load.shaft"]["stiffness"].value == pytest.approx(CUBIC, rel=2e-2)


@pytest.mark.slow
def test_where_nothing_is_missing_two_encoders_tell_nothing(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, 0.0, 0.0, 0.0)
    assert found.verdict is Verdict.COMPLETE
    assert not found.findings
