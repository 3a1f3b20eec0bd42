"""A pendulum that swings out by itself: no actuator, so that the joint is passive and its effort zero."""

from __future__ import annotations

from pathlib import Path

from benchmarks.recordings.rig import Rig, channels, interleaved
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot

MODEL = """[robot]
name = "free-pendulum"
gravity = [0, "-9.81 m/s^2", 0]

[parameters]
m = "0.14758 kg"
a = "0.14775 m"

[dh]
rows = [["q + 90 deg", 0, 0, 0]]

[[joint]]
name = "arm"
passive = true
link = { mass = "m", com = ["a", 0, 0], inertia = { zz = "1.09e-4 kg m^2" } }

"""


def model() -> str:
    """As published, without its viscous friction; the encoder reads pi where the arm hangs."""
    return MODEL + channels({("position", "arm"): "theta [rad]"}) + "\n"


def runs(robot: Robot, folder: Path) -> tuple[Recording, Recording]:
    assert robot.channels is not None
    whole = read_recording(folder / "single_freeswing_1kHz.csv.gz", robot.channels)
    return interleaved(whole, 8)


RIG = Rig(
    name="free_pendulum",
    title="free pendulum at small swing",
    folder="multiarm_pendulum",
    model=model,
    runs=runs,
    split="eight blocks of one swing: trained on the odd ones, judged on the even ones",
    published="viscous friction alone (2.24e-4 N m s/rad); the turning points fall by a constant 0.0050 rad: Coulomb",
)
