"""EMPS: a carriage on a ball screw, from the mass alone."""

from __future__ import annotations

from pathlib import Path

from benchmarks.recordings.rig import Rig
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.machines import machine_file
from symdyn.spec.records import Robot


def runs(robot: Robot, folder: Path) -> tuple[Recording, Recording]:
    assert robot.channels is not None
    files = ("identification.csv.gz", "pulses_validation.csv.gz")
    training, heldout = (read_recording(folder / file, robot.channels) for file in files)
    return training, heldout


RIG = Rig(
    name="emps",
    title="EMPS, carriage on a ball screw",
    folder="emps",
    model=lambda: Path(machine_file("emps")).read_text(encoding="utf-8"),
    runs=runs,
    split="trained on the identification run, judged on the run with disturbance pulses",
    published="mass 95.11 kg, viscous 203.5 N s/m, Coulomb 20.4 N, offset -3.2 N; friction that differs by direction",
)
