"""A geared hobby servo that follows a reference with a pendulum on it: several gains, several weights, no effort."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from benchmarks.recordings.rig import Rig
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot

Table = dict[str, NDArray]
Wanted = tuple[tuple[str, ...], tuple[int, ...], tuple[float, ...]]

SUPPLY, DUTY = 12.0, 0.16489  # V; duty per rad and unit of the servo's gain
LENGTH, ARM = 0.15, 0.05  # m, kg
MODEL = f"""[robot]
name = "servo-gains"
gravity = [0, "-9.81 m/s^2", 0]

[parameters]
weight = "0.75 kg"                    # of a load whose size is known
gain = "32 V/rad"                     # of the loop, as set

[dh]
rows = [["q - 90 deg", 0, 0, 0]]

[[joint]]
name = "servo"

[joint.link]
mass = {ARM}
com = [{LENGTH / 2}, 0, 0]
inertia = {{ about = "joint", zz = {ARM * LENGTH**2 / 3:.5g} }}

[joint.drive]                         # seen from the horn: 12 V make 2.9 N m, or 45 turns per minute
ratio = 1
rotors = [{{ name = "motor", inertia = 0.01, fixed_to_joint = true }}]

[joint.drive.motor]
at = "motor"
name = "circuit"
resistance = 4.4
inductance = 0
torque_constant = 1.1
back_emf_constant = 1.1

[tool]
placement = {{ xyz = [{LENGTH}, 0, 0] }}
mass = "weight"

[[effect]]
type = "position_servo"
at = "servo.motor"
proportional = "gain"
limit = {SUPPLY}

[recording]
time = {{ column = "t", unit = "s" }}

[[recording.channel]]
column = "goal"
quantity = "reference"
joint = "servo"
unit = "rad"

[[recording.channel]]
column = "position"
quantity = "position"
joint = "servo"
unit = "rad"

[[recording.channel]]
column = "weight"
quantity = "parameter"
parameter = "weight"
unit = "kg"

[[recording.channel]]
column = "gain"
quantity = "parameter"
parameter = "gain"
unit = "V/rad"
"""
# trajectories, gains and weights
TRAINED = ("sin_time_square", "up_and_down"), (8, 16, 32), (0.535, 0.969)
JUDGED = ("sin_sin",), (12, 24), (0.741,)
NEAR = 1e-3  # m, kg
ENABLED = 8  # column: whether the servo drives
PAUSE = 1.0  # s between runs


def runs(robot: Robot, folder: Path) -> tuple[Recording, Recording]:
    with np.load(folder / "sts3215_runs.npz", allow_pickle=False) as file:
        table = {name: file[name] for name in ("data", "trajectory", "kp", "mass", "length")}
    return _read(robot, table, "fitted", TRAINED), _read(robot, table, "judged", JUDGED)


def _read(robot: Robot, table: Table, name: str, wanted: Wanted) -> Recording:
    """By way of a file, as a user's recordings come: with all that is checked there."""
    found, begin = [], 0.0
    for trajectory, kp, mass in product(*wanted):
        here = (table["trajectory"] == trajectory) & (table["kp"] == kp) & (np.abs(table["length"] - LENGTH) < NEAR)
        run = table["data"][here & (np.abs(table["mass"] - mass) < NEAR)][0].astype(np.float64)
        time, goal, shown = run[np.all(np.isfinite(run[:, :3]), axis=1) & (run[:, ENABLED] > 0), :3].T
        told = np.ones_like(time)
        found.append(np.column_stack([time - time[0] + begin, goal, shown, mass * told, SUPPLY * DUTY * kp * told]))
        begin = found[-1][-1, 0] + PAUSE
    assert robot.channels is not None
    with TemporaryDirectory() as at:
        path = Path(at) / f"{name}.csv"
        np.savetxt(path, np.vstack(found), "%.9g", ",", header="t,goal,position,weight,gain", comments="")
        return read_recording(path, robot.channels)


RIG = Rig(
    name="servo_gains",
    title="servo pendulum, following",
    folder="sts_servo_pendulum",
    model=lambda: MODEL,
    runs=runs,
    split="trained on two weights and three gains, one run of each of two references, judged on another weight, two "
    "other gains and another reference",
    published="Coulomb 0.16 to 0.18 N m on passive drops, Stribeck 0.084 rad/s, viscous 0.076 N m s/rad; whether "
    "friction depends on the load is disputed; backlash at high gains; a position offset of -0.008 to -0.014 rad",
    remark="The loop's gains are those that were set; its limit is the supply's voltage. The motor is what its data "
    "sheet says, seen from the horn.",
)
