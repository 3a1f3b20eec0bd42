"""An arm with weight behind a soft gear, its equations written by hand: torque and angle of the motor are recorded."""

from __future__ import annotations

import math
from types import MappingProxyType

import numpy as np
from numba import njit
from numpy.typing import NDArray

from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Side

Array = NDArray[np.float64]

RATIO = 50.0
TRUE = {"m": 3.0, "r": 0.3, "I": 0.03, "J": 1e-4, "k": 0.06, "d": 3e-5, "b": 1e-4}
STEP, PARTS, DURATION = 0.002, 40, 12.0  # s
ENCODER = 2.0 * math.pi / 4096

TOML = """[robot]
name = "arm"
gravity = [0, "-9.81 m/s^2", 0]

[parameters]
m = "3.3 kg"
r = "0.28 m"
I = "0.035 kg m^2"
J = "1.1e-4 kg m^2"
k = "0.05 N m/rad"
d = "2e-5 N m s/rad"
b = "1.2e-4 N m s/rad"

[dh]
rows = [["q", 0, 0, 0]]

[[joint]]
name = "arm"
link = { mass = "m", com = ["r", 0, 0], inertia = { about = "com", zz = "I" } }

[joint.drive]
ratio = 50
rotors = [{ name = "motor", inertia = "J" }]
shafts = [{ name = "gear", from = "motor", to = "joint", stiffness = "k", damping = "d" }]
effort_at = "motor"

[[effect]]
type = "viscous_friction"
at = "arm.motor"
coefficient = "b"
"""


def run(seed: int, dry: float = 0.0, cubic: float = 0.0, play: float = 0.0, root: float = 0.0) -> Recording:
    """``dry`` friction of the arm in N m, ``cubic`` stiffness of the gear in N m/rad^3, half its ``play`` in rad.

    ``root``: friction of the motor that grows as the root of its speed, in N m at 1 rad/s.
    """
    rng = np.random.default_rng([seed, 9])
    time = np.arange(0.0, DURATION, STEP)
    order = np.array([1, 2, 3, 5, 8, 13])
    waves = np.sin(2.0 * np.pi * (0.12 if seed == 1 else 0.1) * np.outer(time, order) + rng.uniform(0.0, 6.28, 6))
    reference = waves @ (rng.uniform(0.4, 1.0, 6) / np.sqrt(order))
    reference = reference / np.abs(reference).max() - 0.6
    angle, torque = simulate(reference, np.gradient(reference, time), dry, cubic, play, root, *TRUE.values())
    channels = {
        (Quantity.EFFORT, "arm", Side.MOTOR): torque,
        (Quantity.POSITION, "arm.motor", Side.LINK): ENCODER * np.round(angle / ENCODER),
    }
    return Recording(f"run {seed}", time, MappingProxyType(channels), STEP, (slice(0, len(time)),), (), "0" * 64)


@njit
def simulate(
    reference: Array,
    speeds: Array,
    dry: float,
    cubic: float,
    play: float,
    root: float,
    m: float,
    r: float,
    inertia: float,
    rotor: float,
    k: float,
    d: float,
    b: float,
) -> tuple[Array, Array]:
    """Angle of the motor, and its torque, held over each sample; semi-implicit steps, dry friction set-valued."""
    q, w, weight = reference[0], speeds[0], m * 9.81 * r
    angle, speed = RATIO * q + weight * math.cos(q) / RATIO / k, RATIO * w
    total, last, filtered = 0.0, angle, 0.0
    angles, torques = np.zeros(len(reference)), np.zeros(len(reference))
    h, whole = STEP / PARTS, inertia + m * r * r
    for i in range(len(reference)):
        error = RATIO * reference[i] - angle
        total += error * STEP
        filtered += 0.3 * ((angle - last) / STEP - filtered)
        last = angle
        torque = 0.05 * error + 0.15 * total + 2e-3 * (RATIO * speeds[i] - filtered)
        torque += weight * math.cos(reference[i]) / RATIO
        angles[i], torques[i] = angle, torque
        for _ in range(PARTS):
            twist = angle - RATIO * q
            touches = abs(twist) > play
            twist -= math.copysign(play, twist)
            shaft = k * twist + d * (speed - RATIO * w) + cubic * twist**3 if touches else 0.0
            drag = b * speed + root * math.copysign(math.sqrt(abs(speed)), speed)
            new_speed = speed + h * (torque - shaft - drag) / rotor
            new_w = w + h * (RATIO * shaft - weight * math.cos(q)) / whole
            hold = dry * h / whole
            new_w = 0.0 if abs(new_w) <= hold else new_w - math.copysign(hold, new_w)
            angle += 0.5 * h * (speed + new_speed)
            q += 0.5 * h * (w + new_w)
            speed, w = new_speed, new_w
    return angles, torques
