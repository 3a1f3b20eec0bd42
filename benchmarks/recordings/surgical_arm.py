"""da Vinci patient-side arm, without a weight and with 205 g at its tip: two turning joints and the insertion."""

from __future__ import annotations

from pathlib import Path

from benchmarks.recordings.rig import Rig, channels
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot

MODEL = """[robot]
name = "surgical-arm"
gravity = [0, 0, "-9.81 m/s^2"]

[dh]
convention = "modified"
rows = [["q + 90 deg", 0,            0, "90 deg" ],
        ["q - 90 deg", 0,            0, "-90 deg"],
        [0,            "q - 0.4318 m", 0, "90 deg" ]]

[[joint]]
name = "yaw"
link = { mass = 3, com = [0.01, 0.01, 0.01], inertia = { xx = 0.05, yy = 0.05, zz = 0.05 } }

[[joint]]
name = "pitch"
link = { mass = 2, com = [0.05, 0.05, 0.01], inertia = { xx = 0.05, yy = 0.05, zz = 0.05 } }

[[joint]]
name = "insertion"
kind = "prismatic"
link = { mass = 0.5, com = [0.01, 0.01, 0.05], inertia = { xx = 1e-3, yy = 1e-3, zz = 1e-3 } }

"""


def model() -> str:
    columns = {
        ("position", "yaw"): "q1 [rad]",
        ("effort", "yaw"): "tau1 [N m]",
        ("position", "pitch"): "q2 [rad]",
        ("effort", "pitch"): "tau2 [N m]",
        ("position", "insertion"): "q3 [m]",
        ("effort", "insertion"): "tau3 [N]",
    }
    return MODEL.replace('kind = "prismatic"\n', "") + channels(columns) + "\n"


def runs(robot: Robot, folder: Path) -> tuple[Recording, Recording]:
    assert robot.channels is not None
    files = ("one_no_weight_results.csv.gz", "two_results.csv.gz")
    training, heldout = (read_recording(folder / file, robot.channels) for file in files)
    return training, heldout


RIG = Rig(
    name="surgical_arm",
    title="surgical arm, no weight",
    folder="dvrk_psm",
    model=model,
    runs=runs,
    split="trained on one motion without weight, judged on another",
    joints=3,
    published="springs, cable torque, Coulomb 0.05 and viscous 0.09 on joint 1, offset -0.30",
    remark="Three joints of seven; guessed masses, no counterweight, no parallelogram.",
)
