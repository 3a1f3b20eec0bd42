"""Staubli TX40: six joints, motor currents; geometry from the data sheet, guessed masses, no friction."""

from __future__ import annotations

from pathlib import Path

from benchmarks.recordings.rig import Rig, channels, interleaved
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot

ROWS = """[robot]
name = "staubli-tx40"
gravity = [0, 0, "-9.81 m/s^2"]

[dh]
convention = "modified"
rows = [ ["q",          0,     0,     0        ],
         ["q - 90 deg", 0,     0,     "-90 deg"],
         ["q + 90 deg", 0.035, 0.225, 0        ],
         ["q",          0.225, 0,     "90 deg" ],
         ["q",          0,     0,     "-90 deg"],
         ["q",          0.065, 0,     "90 deg" ] ]
"""
RATIOS = (32, 32, 45, 48, 45, 32)  # joint 4 turns the other way in the source, but not in its recording
MASSES = (8.0, 8.0, 5.0, 3.0, 1.0, 0.3)  # kg, guessed
COMS = ((0.01, 0.01, 0.01), (0.1, 0.01, 0.05), (0.01, 0.01, 0.05), (0.01, 0.01, -0.05), (0.01, 0.01, 0.01), (0.01,) * 3)


def model() -> str:
    text, columns = ROWS, {}
    for i, (ratio, mass, com) in enumerate(zip(RATIOS, MASSES, COMS, strict=True), start=1):
        inertia = f"{0.01 * mass:.4g}"
        text += f"""
[[joint]]
name = "j{i}"
actuator = {{ gain = "{ratio} N m/A" }}
link = {{ mass = {mass}, com = {list(com)}, inertia = {{ xx = {inertia}, yy = {inertia}, zz = {inertia} }} }}
"""
        columns |= {("position", f"j{i}"): f"q_deg{i} [deg]", ("current", f"j{i}"): f"i_A{i} [A]"}
    return f"{text}\n{channels(columns)}\n"


def runs(robot: Robot, folder: Path) -> tuple[Recording, Recording]:
    assert robot.channels is not None
    return interleaved(read_recording(folder / "exciting_1kHz.csv.gz", robot.channels), 6)


RIG = Rig(
    name="staubli",
    title="Staubli TX40, six joints",
    folder="staubli_tx40",
    model=model,
    runs=runs,
    split="six blocks of one run of 9 s: trained on the odd ones, judged on the even ones",
    joints=6,
    published="viscous 8.05 5.53 1.97 1.11 1.86 0.65, Coulomb 7.14 8.26 6.34 2.48 3.03 0.28, rotors; coupled wrist",
    remark="Effort is gear ratio times current: the torque constant is not in the source. No coupled wrist.",
)
