"""A geared hobby servo that holds a position while two others pull at it, first this way, then that way."""

from __future__ import annotations

import csv
import gzip
import math
from datetime import datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.recordings.rig import Rig, channels, effort, interleaved, made, position
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Robot

HELD = 2047.0  # counts
ARRIVED = 20.0  # counts: farther off, the servo is still on its way
REST = {"(3)": 1748.0, "(4)": 2347.0}  # counts, where the two let go
SLACK = 20.0  # counts
PULL = 36.0  # counts of load of a servo that pulls and stands still
MODEL = """[robot]
name = "servo-held"
gravity = [0, 0, 0]

[dh]
rows = [["q", 0, 0, 0]]

[[joint]]
name = "horn"
link = { inertia = { zz = 0.01 } }

[joint.drive]
ratio = 1
rotors = [{ name = "motor", inertia = 0.01 }]
shafts = [{ name = "gears", from = "motor", to = "joint", stiffness = 20, damping = 1 }]

[[effect]]
type = "linear_spring"                # the servo loop, which holds
at = "horn.motor"
stiffness = 20

[[effect]]
type = "viscous_friction"
at = "horn.motor"
coefficient = 1

[[effect]]
type = "viscous_friction"             # let go, the horn would fly across any gap without it
at = "horn"
coefficient = 1

"""


def runs(robot: Robot, folder: Path) -> tuple[Recording, Recording]:
    return interleaved(_run(folder / "single.csv.gz", "(5)", ("(3)", "(4)")), 4)


def _run(file: Path, held: str, pullers: tuple[str, str]) -> Recording:
    times: list[float] = []
    rows: list[tuple[float, float]] = []
    with gzip.open(file, "rt", encoding="utf-8", newline="") as text:
        for row in csv.DictReader(text):
            if not row[f"pos {held}"] or float(row[f"target pos {held}"]) != HELD:
                continue
            if abs(float(row[f"pos {held}"]) - HELD) > ARRIVED:
                continue
            times.append(datetime.fromisoformat(row["timestamp"]).timestamp())
            pull = sum(_pulls(row, puller) for puller in pullers)
            rows.append((float(row[f"pos {held}"]) - HELD, pull))
    table: NDArray[np.float64] = np.array(rows)
    return made("held", np.array(times) - times[0], {position("horn"): table[:, 0], effort("horn"): table[:, 1]})


def _pulls(row: dict[str, str], puller: str) -> float:
    """How a servo pulls that stands still; while it moves, its load says nothing of how hard it pulls."""
    away = float(row[f"pos {puller}"]) - REST[puller]
    return math.copysign(PULL, -away) if abs(away) > SLACK else 0.0


RIG = Rig(
    name="servo_backlash",
    title="servo held and pulled",
    folder="uart_servo_backlash",
    model=lambda: MODEL + channels({("position", "horn"): "position [rad]", ("effort", "horn"): "pull [N m]"}) + "\n",
    runs=runs,
    split="four blocks of one run: trained on the odd ones, judged on the even ones",
    published="backlash of 14.2 to 14.8 counts, from one mean position under pull to the other: the gap and what the "
    "pull winds up; let go, the horn rests at places 7 to 11 counts apart",
    remark="1 rad stands for 1 count of the encoder; a clearance is half of a gap. Of the pull only its direction is "
    "known: its size is set to 36 counts of load, as when the pulling servos stand still.",
)
