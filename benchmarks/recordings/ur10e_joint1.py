"""UR10e, base joint alone, moved slowly over three radians: what a single axis with a harmonic drive shows."""

from __future__ import annotations

from pathlib import Path

from benchmarks.recordings.rig import Rig, channels, cut
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot

MODEL = """[robot]
name = "ur10e-joint1"
gravity = [0, 0, -9.81]

[dh]
rows = [["q", 0, 0, 0]]

[[joint]]
name = "base"
link = { inertia = { about = "joint", zz = "9 kg m^2" } }
actuator = { gain = "14.87 N m/A" }

"""


def model() -> str:
    return MODEL + channels({("position", "base"): "q1 [rad]", ("current", "base"): "i1 [A]"}) + "\n"


def runs(robot: Robot, folder: Path) -> tuple[Recording, Recording]:
    assert robot.channels is not None
    whole = read_recording(folder / "20_01_22-joint_1.csv.gz", robot.channels)
    half = len(whole.time) // 2
    return cut(whole, "first half", [slice(0, half)]), cut(whole, "second half", [slice(half, len(whole.time))])


RIG = Rig(
    name="ur10e_joint1",
    title="UR10e, base joint alone",
    folder="ur10e",
    model=model,
    runs=runs,
    split="trained on the first half, judged on the second",
    published="viscous, Coulomb and degressive friction; ripple at order 202",
)
