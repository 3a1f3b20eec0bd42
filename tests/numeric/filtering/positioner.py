"""A geared arm behind a position servo, of which nothing is recorded but what it is asked for and where it is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

MODEL = """
[robot]
name = "positioner"
gravity = [0, "-9.81 m/s^2", 0]

[parameters]
J_m = "2.6e-5 kg m^2"
m = "1.3 kg"
c = "0.2 m"
J_l = "0.1 kg m^2"
R = "2.2 Ohm"
K_t = "0.042 N m/A"
K_e = "0.042 V s/rad"
b_m = "2.9e-5 N m s/rad"
P = "3.6 V/rad"
D = "0.025 V s/rad"

[dh]
rows = [["q - 90 deg", 0, 0, 0]]

[[joint]]
name = "arm"
link = { mass = "m", com = ["c", 0, 0], inertia = { about = "joint", zz = "J_l" } }

[joint.drive]
ratio = 80
rotors = [{ name = "motor", inertia = "J_m", fixed_to_joint = true }]

[joint.drive.motor]
at = "motor"
name = "circuit"
resistance = "R"
inductance = 0
torque_constant = "K_t"
back_emf_constant = "K_e"

[[effect]]
type = "viscous_friction"
at = "arm.motor"
coefficient = "b_m"

[[effect]]
type = "position_servo"
at = "arm.motor"
proportional = "P"
derivative = "D"
limit = 1000

[recording]
time = { column = "t", unit = "s" }
[[recording.channel]]
column = "asked"
quantity = "reference"
joint = "arm"
unit = "rad"
[[recording.channel]]
column = "shown"
quantity = "position"
joint = "arm"
unit = "rad"
"""
GAIN = """[[recording.channel]]
column = "P"
quantity = "parameter"
parameter = "P"
unit = "V/rad"
"""
RATIO, FINE = 80.0, 100  # steps of the plant in each sample
J_M, J_L, R, K, B, D, WEIGHT = 3.1e-5, 0.12, 1.9, 0.047, 2.2e-5, 0.021, 1.45 * 0.21 * 9.81  # the plant, in SI units
TURN = 8192  # counts of the encoder


@njit
def simulated(asked: Array, rate: float, gain: float, dry: float, limit: float) -> Array:
    """Angle of the arm at every sample, by small steps: a plant of its own."""
    shown, x, v = np.zeros(len(asked)), 0.0, 0.0
    inertia, step = J_M + J_L / RATIO**2, 1.0 / rate / FINE
    for i in range(len(asked) - 1):
        shown[i] = x / RATIO
        for j in range(FINE):
            reference = asked[i] + (asked[i + 1] - asked[i]) * j / FINE
            voltage = min(max(gain * (reference - x) - D * v, -limit), limit)
            free = v + step / inertia * (K * (voltage - K * v) / R - B * v - WEIGHT / RATIO * np.sin(x / RATIO))
            v = np.sign(free) * max(abs(free) - step / inertia * dry / RATIO, 0.0)
            x += step * v
    shown[-1] = x / RATIO
    return shown


def recorded(
    file: Path,
    robot: Robot,
    seed: int,
    rate: float = 500.0,
    seconds: float = 8.0,
    gain: float = 4.2,
    dry: float = 0.0,
    limit: float = 1e9,
    late: float = 0.0,
) -> Recording:
    """Read back from a file, as a user's. ``dry``: N m at the arm; ``limit``: V; ``late``: s of what is asked for."""
    random = np.random.default_rng(seed)
    time = np.arange(int(seconds * rate)) / rate
    waves = [(f * random.uniform(0.9, 1.1), random.uniform(0.0, 2.0 * np.pi)) for f in (0.17, 0.43, 0.9, 1.7, 3.1, 5.5)]

    def asked(at: Array) -> Array:
        course = sum(np.sin(2.0 * np.pi * f * at + phase) / np.sqrt(f) for f, phase in waves)
        return np.asarray(12.0 * course * np.clip(at / 0.3, 0.0, 1.0))

    shown = simulated(asked(time - late), rate, gain, dry, limit)
    steps = 2.0 * np.pi / TURN
    columns = [time, asked(time), np.round(shown / steps) * steps, np.full_like(time, gain)]
    np.savetxt(file, np.column_stack(columns), "%.9g", ",", header="t,asked,shown,P", comments="")
    assert robot.channels is not None
    return read_recording(file, robot.channels)
