"""A geared hobby servo whose torque is switched off: its pendulum falls against the friction of the gears."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.recordings.rig import Rig, channels, made, position
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Robot

MASS, LENGTH, ARM = 0.969, 0.15, 0.05  # kg, m, kg
MODEL = f"""[robot]
name = "servo-drop"
gravity = [0, "-9.81 m/s^2", 0]

[dh]
rows = [["q - 90 deg", 0, 0, 0]]

[[joint]]
name = "servo"
passive = true

[joint.link]
mass = {MASS + ARM:.5g}
com = [{(MASS * LENGTH + ARM * LENGTH / 2) / (MASS + ARM):.5g}, 0, 0]
inertia = {{ about = "joint", zz = {MASS * LENGTH**2 + ARM * LENGTH**2 / 3:.5g} }}

"""
MARGIN = 5  # samples after the switch
REST = 0.1  # rad/s
SHORTEST = 100  # samples of a drop


def runs(robot: Robot, folder: Path) -> tuple[Recording, Recording]:
    with np.load(folder / "sts3215_runs.npz", allow_pickle=False) as table:
        data, mass, length = table["data"], table["mass"], table["length"]
        wanted = (table["trajectory"] == "lift_and_drop") & np.isclose(mass, MASS) & np.isclose(length, LENGTH)
    drops = data[wanted]
    return _joined("odd drops", drops[0::2]), _joined("even drops", drops[1::2])


def _joined(name: str, data: NDArray[np.float32]) -> Recording:
    times, angles, breaks, offset = [], [], [], 0.0
    for run in data.astype(np.float64):
        free = np.flatnonzero((run[:, 8] == 0) & (run[:, 0] > 1.5) & np.isfinite(run[:, 2]))[MARGIN:]
        moving = free[np.abs(run[free, 3]) > REST]
        free = free[free <= moving[-1]] if len(moving) else free[:0]  # friction at rest is whatever holds
        if len(free) < SHORTEST:
            continue
        breaks.append(sum(len(t) for t in times))
        times.append(run[free, 0] - run[free[0], 0] + offset)
        angles.append(run[free, 2])
        offset = float(times[-1][-1]) + 1.0
    return made(name, np.concatenate(times), {position("servo"): np.concatenate(angles)}, breaks[1:])


RIG = Rig(
    name="servo_drop",
    title="servo pendulum, torque off",
    folder="sts_servo_pendulum",
    model=lambda: MODEL + channels({("position", "servo"): "position [rad]"}) + "\n",
    runs=runs,
    split="drops of 0.969 kg at 0.15 m: trained on every other one, judged on the rest",
    published="Coulomb 0.16 to 0.18 N m on passive drops, viscous 0.076 N m s/rad; load dependence not proven",
    remark="No effort acts, so that mass and arm are taken as given.",
)
