"""An elastic joint that a torque drives: what is missing is named, by an encoder at the motor alone or at both ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Diagnosis
from symdyn.numeric.recording import read_recording

Array = NDArray[np.float64]

RATIO, MASS, CENTRE, INERTIA, ROTOR, STIFFNESS, DAMPING, DRAG = (
    100.0,
    12.0,
    0.4,
    3.2,
    3e-4,
    2.0,
    2e-3,
    8e-4,
)  # the truth
STEP, PARTS, SECONDS = 2e-3, 100, 10.0
MODEL = """[robot]
name = "elastic"
gravity = [0, "-9.81 m/s^2", 0]

[dh]
rows = [["q", 0, 0, 0]]

[[joint]]
name = "arm"
link = { mass = 10, com = ["0.4 m", 0, 0], inertia = { about = "joint", zz = 4 } }

[joint.drive]
ratio = 100
rotors = [{ name = "motor", inertia = 2.6e-4 }]
shafts = [{ name = "gear", from = "motor", to = "joint", stiffness = 1.6, damping = 3e-3 }]
effort_at = "motor"

[[effect]]
type = "viscous_friction"
at = "arm.motor"
coefficient = 1e-3

[recording]
time = { column = "t", unit = "s" }

[[recording.channel]]
column = "tau"
quantity = "effort"
joint = "arm"
side = "motor"
unit = "N m"

[[recording.channel]]
column = "qm"
quantity = "position"
joint = "arm"
side = "motor"
unit = "rad"
"""
LINK_ENCODER = """
[[recording.channel]]
column = "ql"
quantity = "position"
joint = "arm"
unit = "rad"
"""


@njit
def simulated(wanted: Array, wanted_speed: Array, play: float, dry: float) -> Array:
    """(N, 3) torque, motor angle and arm angle under a controller at the motor; semi-implicit Euler at 20 us.

    ``play`` is half of the gear's, at the motor; dry friction at the motor brakes to a stop within a step.
    """
    h, out = STEP / PARTS, np.zeros((len(wanted), 3))
    qm, vm, q, v = RATIO * wanted[0], 0.0, wanted[0], 0.0
    for k in range(len(wanted)):
        torque = 0.02 * (RATIO * wanted[k] - qm) + 0.004 * (RATIO * wanted_speed[k] - vm)
        torque += MASS * 9.81 * CENTRE * np.cos(wanted[k]) / RATIO
        out[k] = torque, qm, q
        for _ in range(PARTS):
            twist = qm - RATIO * q
            beyond = np.sign(twist) * max(abs(twist) - play, 0.0)
            force = STIFFNESS * beyond + (DAMPING * (vm - RATIO * v) if beyond else 0.0)
            vm += h / ROTOR * (torque - force - DRAG * vm)
            vm = np.sign(vm) * max(abs(vm) - dry * h / ROTOR, 0.0)
            v += h / INERTIA * (RATIO * force - MASS * 9.81 * CENTRE * np.cos(q))
            qm, q = qm + h * vm, q + h * v
    return out


def diagnosed(folder: Path, model: str, play: float = 0.0, dry: float = 0.0) -> Diagnosis:
    robot, runs = robot_from_text(model, "elastic.toml"), []
    assert robot.channels is not None
    for seed in (1, 2):
        rng, time = np.random.default_rng(seed), np.arange(0.0, SECONDS, STEP)
        wanted, speed = np.zeros((2, len(time)))
        for f in (0.1, 0.2, 0.3, 0.5, 0.7, 1.1, 1.9, 2.9):
            size, angle = 0.35 / (1.0 + (f / 0.5) ** 1.5) * rng.uniform(0.6, 1.0), rng.uniform(0.0, 2.0 * np.pi)
            wanted += size * np.sin(2.0 * np.pi * f * time + angle)
            speed += size * 2.0 * np.pi * f * np.cos(2.0 * np.pi * f * time + angle)
        table = simulated(wanted, speed, play, dry)
        table[:, 0] += rng.normal(0.0, 3e-3, len(time))
        for column, steps in ((1, 2**16), (2, 2**20)):
            table[:, column] = np.round(table[:, column] * steps / (2.0 * np.pi)) * 2.0 * np.pi / steps
        path = folder / f"{seed}.csv"
        np.savetxt(path, np.column_stack([time, table]), delimiter=",", header="t,tau,qm,ql", comments="", fmt="%.9g")
        runs.append(read_recording(path, robot.channels))
    return diagnose(robot, *runs)


@pytest.mark.slow  # four diagnoses that compile two machines
def test_an_elastic_joint_that_lacks_nothing_is_complete(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, MODEL + LINK_ENCODER)
    assert (found.verdict, found.findings) == ("complete", ())
    for name, true in (("arm_motor_inertia", ROTOR), ("arm_gear_stiffness", STIFFNESS), ("arm_inertia_zz", INERTIA)):
        assert found.model[name].value == pytest.approx(true, rel=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("sensors", "surest"), [(LINK_ENCODER, 0.03), ("", 0.06)])  # rad: what each tells it to
def test_play_of_the_gear_is_named_and_placed(tmp_path: Path, sensors: str, surest: float) -> None:
    found = diagnosed(tmp_path, MODEL + sensors, play=0.3)
    assert [(f.effect, f.place) for f in found.findings] == [("backlash", "arm.gear")]
    clearance = found.findings[0].parameters["clearance"]
    assert clearance.se is not None
    assert abs(clearance.value - 0.3) < 3.0 * clearance.se < 3.0 * surest


@pytest.mark.slow
def test_a_gear_that_the_model_takes_for_rigid_is_told_by_the_encoders_of_both_its_ends(tmp_path: Path) -> None:
    shafts = next(line for line in MODEL.splitlines() if line.startswith("shafts"))
    rigid = MODEL.replace(shafts, "").replace("inertia = 2.6e-4 }", "inertia = 2.6e-4, fixed_to_joint = true }")
    found = diagnosed(tmp_path, rigid.replace('effort_at = "motor"', "") + LINK_ENCODER)
    assert [(f.effect, f.place) for f in found.findings] == [("joint_compliance", "arm")]
    stiffness = found.findings[0].parameters["stiffness"]
    assert stiffness.se is not None
    assert abs(stiffness.value - STIFFNESS) < 3.0 * stiffness.se < 0.1 * STIFFNESS
    (drive,) = [joint.drive for joint in found.diagnosed.joints]
    assert drive is not None
    assert drive.effort_at == "motor"  # where its torque was measured


@pytest.mark.slow
def test_dry_friction_of_the_motor_is_told_in_the_units_of_its_torque(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, MODEL + LINK_ENCODER, dry=0.08)
    assert [(f.effect, f.place) for f in found.findings] == [("coulomb_friction", "arm.motor")]
    level = found.findings[0].parameters["level"]
    assert level.se is not None
    assert abs(level.value - 0.08) < 3.0 * level.se < 1e-3
