"""Two links with quasi-direct drives that swing up; published masses and lengths, no friction, no rotors."""

from __future__ import annotations

from pathlib import Path

from benchmarks.recordings.rig import Rig, channels
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot

MODEL = """[robot]
name = "double-pendulum"
gravity = ["9.81 m/s^2", 0, 0]

[dh]
convention = "modified"
rows = [["q", 0, 0, 0], ["q", 0, "l1", 0]]

[parameters]
l1 = "0.3 m"

[[joint]]
name = "shoulder"
link = { mass = "0.559 kg", com = ["0.275 m", 0, 0], inertia = { about = "joint", zz = "0.0535 kg m^2" } }

[[joint]]
name = "elbow"
link = { mass = "0.604 kg", com = ["0.166 m", 0, 0], inertia = { about = "joint", zz = "0.0239 kg m^2" } }

"""


def model() -> str:
    columns = {}
    for i, joint in enumerate(("shoulder", "elbow"), start=1):
        columns |= {("position", joint): f"pos_meas{i} [rad]", ("effort", joint): f"tau_meas{i} [N m]"}
    return MODEL + channels(columns, time="time") + "\n"


def runs(robot: Robot, folder: Path) -> tuple[Recording, Recording]:
    assert robot.channels is not None
    files = ("design_A_00.csv.gz", "design_A_01.csv.gz")
    training, heldout = (read_recording(folder / file, robot.channels) for file in files)
    return training, heldout


RIG = Rig(
    name="double_pendulum",
    title="double pendulum, quasi-direct drives (design A)",
    folder="dfki_double_pendulum",
    model=model,
    runs=runs,
    split="trained on one run of 10 s, judged on another",
    joints=2,
    published="Coulomb 0.093 and 0.078 N m, rotors 0.0028 kg m^2; the torque lags its command",
    remark="A hard case: torque is what the drives report.",
)
