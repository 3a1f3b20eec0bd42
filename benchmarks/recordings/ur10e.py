"""UR10e: six joints with harmonic drives, motor currents; the maker's rigid model without any friction."""

from __future__ import annotations

from pathlib import Path

from benchmarks.recordings.rig import Rig, channels
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.machines import machine_file
from symdyn.spec.records import Robot

GAINS = {  # N m/A, quoted in the source from De Luca
    "shoulder_pan": 14.87,
    "shoulder_lift": 13.26,
    "elbow": 11.13,
    "wrist1": 10.62,
    "wrist2": 11.03,
    "wrist3": 11.47,
}


def model() -> str:
    text = Path(machine_file("ur10e")).read_text(encoding="utf-8")
    for joint, gain in GAINS.items():
        text = text.replace(f'name = "{joint}"\n', f'name = "{joint}"\nactuator = {{ gain = "{gain} N m/A" }}\n')
    columns = {}
    for i, joint in enumerate(GAINS, start=1):
        columns |= {("position", joint): f"q{i} [rad]", ("current", joint): f"i{i} [A]"}
    return f"{text}\n{channels(columns)}\n"


def runs(robot: Robot, folder: Path) -> tuple[Recording, Recording]:
    assert robot.channels is not None
    files = ("20_02_19_14harm50sec.csv.gz", "20_02_19_15harm50sec.csv.gz")
    training, heldout = (read_recording(folder / file, robot.channels) for file in files)
    return training, heldout


RIG = Rig(
    name="ur10e",
    title="UR10e, six joints",
    folder="ur10e",
    model=model,
    runs=runs,
    split="trained on the 50 s run with 14 harmonics, judged on the one with 15",
    joints=6,
    published="degressive friction; ripple of the harmonic drives near 202 waves per turn of a joint (gear ratio 101)",
)
