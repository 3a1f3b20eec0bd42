"""Franka Panda: seven joints with torque sensors behind the gears; published inertias, no friction."""

from __future__ import annotations

from pathlib import Path

from benchmarks.recordings.rig import Rig, channels, interleaved
from symdyn.compiler import load_robot
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.machines import machine_file
from symdyn.spec.records import Robot


def model() -> str:
    text = Path(machine_file("panda")).read_text(encoding="utf-8")
    columns = {}
    for i, joint in enumerate(load_robot("panda").joints, start=1):
        columns |= {("position", joint.name): f"q{i} [rad]", ("effort", joint.name): f"tau{i} [N m]"}
    return f"{text}\n{channels(columns)}\n"


def runs(robot: Robot, folder: Path) -> tuple[Recording, Recording]:
    assert robot.channels is not None
    return interleaved(read_recording(folder / "exciting.csv.gz", robot.channels), 6)


RIG = Rig(
    name="panda",
    title="Franka Panda, seven joints",
    folder="panda_cognetti",
    model=model,
    runs=runs,
    split="six blocks of one run of 21 s: trained on the odd ones, judged on the even ones",
    joints=7,
    published="friction of sigmoid shape that differs by direction, on every joint (Gaz et al. 2019)",
)
