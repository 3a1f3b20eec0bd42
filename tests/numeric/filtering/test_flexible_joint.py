"""An industrial joint with an elastic gear, recorded at the motor alone: what is missing beyond the gear is named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Diagnosis, Verdict
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

RATE, SECONDS, PARTS = 1000.0, 8.0, 50
MODEL = """[robot]
name = "axis"
gravity = [0, -9.81, 0]

[dh]
rows = [["q", 0, 0, 0]]

[[joint]]
name = "arm"
link = { mass = 5, com = [0.25, 0, 0], inertia = { about = "joint", zz = 1.0 } }

[joint.drive]
ratio = 100
rotors = [{ name = "motor", inertia = 1.2e-4 }]
shafts = [{ name = "gear", from = "motor", to = "joint", stiffness = 0.8, damping = 1.3e-3 }]

[joint.drive.motor]
name = "circuit"
at = "motor"
resistance = 1.1
inductance = 0.001
torque_constant = 0.055
back_emf_constant = 0.05

[[effect]]
type = "viscous_friction"
at = "arm.motor"
coefficient = 1.2e-4

[[effect]]
type = "viscous_friction"
at = "arm"
coefficient = 0.25

[recording]
time = { column = "t", unit = "s" }

[[recording.channel]]
column = "u"
quantity = "voltage"
joint = "arm"
unit = "V"

[[recording.channel]]
column = "i"
quantity = "current"
joint = "arm"
unit = "A"

[[recording.channel]]
column = "qm"
quantity = "position"
joint = "arm.motor"
unit = "rad"
"""


@njit
def simulated(wanted: Array, wanted_speed: Array, clearance: float, dry: float) -> Array:
    """(N, 3) voltage, current and motor angle under a controller; the voltage is held over a sample.

    ``clearance``: half the play of the gear, rad at the motor; ``dry``: Coulomb friction at the arm, N m.
    """
    ratio, rotor, link, resistance, inductance, constant = 100.0, 1e-4, 1.2, 1.0, 1e-3, 0.05
    stiffness, damping, weight, motor_drag, arm_drag = 1.0, 1e-3, 14.0, 1e-4, 0.3
    h = 1.0 / RATE / PARTS
    motor = motor_speed = arm = arm_speed = current = 0.0
    shown = np.zeros((len(wanted), 3))
    for k in range(len(wanted)):
        voltage = 1.5 * (wanted[k] - motor) + 0.03 * (wanted_speed[k] - motor_speed)
        shown[k] = voltage, current, motor
        for _ in range(PARTS):
            twist, rate = motor - ratio * arm, motor_speed - ratio * arm_speed
            bent = twist - min(max(twist, -clearance), clearance)
            torque = stiffness * bent + damping * rate if bent != 0.0 or clearance == 0.0 else 0.0
            if clearance > 0.0 and torque * bent < 0.0:
                torque = 0.0  # contact never pulls
            current += h * (voltage - resistance * current - constant * motor_speed) / inductance
            motor_speed += h * (constant * current - torque - motor_drag * motor_speed) / rotor
            friction = dry * np.tanh(arm_speed / 1e-4) + arm_drag * arm_speed
            arm_speed += h * (ratio * torque - weight * np.cos(arm) - friction) / link
            motor += h * motor_speed
            arm += h * arm_speed
    return shown


def recorded(file: Path, robot: Robot, seed: int, clearance: float = 0.0, dry: float = 0.0) -> Recording:
    """With an encoder of 4096 steps per turn at the motor, and an ammeter's noise of 10 mA."""
    rng = np.random.default_rng(seed)
    time = np.arange(int(RATE * SECONDS)) / RATE
    frequency, phase = rng.uniform(0.2, 3.0, 8), rng.uniform(0.0, 2.0 * np.pi, 8)
    size = rng.uniform(0.5, 1.0, 8) / frequency
    wanted = np.sin(2.0 * np.pi * np.outer(time, frequency) + phase) @ (60.0 * size / size.sum())
    wanted = (wanted - wanted[0]) * np.clip(2.0 * time, 0.0, 1.0)
    shown = simulated(wanted, np.gradient(wanted, time), clearance, dry)
    shown[:, 1] += 0.01 * rng.standard_normal(len(time))
    step = 2.0 * np.pi / 4096
    shown[:, 2] = step * np.round(shown[:, 2] / step)
    np.savetxt(file, np.column_stack([time, shown]), delimiter=",", header="t,u,i,qm", comments="", fmt="%.9g")
    assert robot.channels is not None
    return read_recording(file, robot.channels)


def diagnosed(folder: Path, clearance: float = 0.0, dry: float = 0.0) -> Diagnosis:
    robot = robot_from_text(MODEL, "axis.toml")
    return diagnose(robot, *(recorded(folder / f"{seed}.csv", robot, seed, clearance, dry) for seed in (1, 2)))


@pytest.mark.slow  # whole diagnoses, all of them
def test_nothing_is_found_where_nothing_is_missing(tmp_path: Path) -> None:
    found = diagnosed(tmp_path)
    assert found.verdict is Verdict.COMPLETE
    assert not found.findings


@pytest.mark.slow
def test_play_that_inertias_and_unknown_forces_make_up_for_is_found_on_the_model_as_given(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, clearance=0.03)
    assert [(f.effect, f.place) for f in found.findings] == [("backlash", "arm.gear")]
    told = found.findings[0].parameters["clearance"]
    assert told.se is not None
    assert abs(told.value - 0.03) < 4.0 * told.se < 3e-4
    assert found.after.heldout < 1.1 * found.noise_floor.errors.heldout


@pytest.mark.slow
def test_friction_beyond_the_gear_is_found_though_the_voltage_could_be_blamed_for_the_current(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, dry=2.0)
    assert [f.effect for f in found.findings] == ["coulomb_friction"]
    assert "arm" in (found.findings[0].place, *found.findings[0].group)
    assert found.findings[0].parameters["level"].value == pytest.approx(2.0, rel=0.1)
    assert found.after.heldout < 1.1 * found.noise_floor.errors.heldout
