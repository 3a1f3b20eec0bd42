"""A hobby motor turned slowly by its controller: what it takes to turn it, against the angle."""

from __future__ import annotations

from pathlib import Path

from benchmarks.recordings.rig import Rig, interleaved
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot

MODEL = """[robot]
name = "cogging-motor"
gravity = [0, 0, 0]

[dh]
rows = [["q", 0, 0, 0]]

[[joint]]
name = "rotor"
link = { inertia = { zz = "1 kg m^2" } }

[recording]
time = { column = "t", unit = "s" }

[[recording.channel]]
column = "motor_enc_counts_2048"
quantity = "position"
joint = "rotor"
unit = "rad"
scale = 3.067961575771282e-3

[[recording.channel]]
column = "control"
quantity = "effort"
joint = "rotor"
unit = "N m"
"""


def runs(robot: Robot, folder: Path) -> tuple[Recording, Recording]:
    assert robot.channels is not None
    return interleaved(read_recording(folder / "motor_cogging.csv.gz", robot.channels), 8)


RIG = Rig(
    name="cogging",
    title="motor turned slowly",
    folder="servoproject_cogging",
    model=lambda: MODEL,
    runs=runs,
    split="eight blocks, one way and back: trained on the odd ones, judged on the even ones",
    published="cogging at order 6 (54.8 control units), Coulomb friction (66.8)",
    remark="Effort is the controller's output: 1 N m stands for 1 control unit.",
)
