"""A pendulum with a motor, recorded while it follows sums of sines: torques by hand, no code of symdyn in them."""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from symdyn.compiler import robot_from_text
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Robot, Side

Array = NDArray[np.float64]
Torque = Callable[[Array, Array, Array, Array], Array]  # of time, angle, speed, acceleration; on the resisting side

MASS, ARM, INERTIA, VISCOUS, GRAVITY = 1.5, 0.3, 0.05, 0.2, 9.81
TURNING = INERTIA + MASS * ARM**2  # about the axis
TORQUE_NOISE, ANGLE_NOISE = 0.02, 5e-6
HARMONICS = np.array([1, 2, 3, 5, 7, 11])  # of 0.1 Hz

TOML = f"""
[robot]
name = "pendulum"
gravity = [0, "-g", 0]

[parameters]
g = "{GRAVITY} m/s^2"
m = "{MASS} kg"
r = "{ARM} m"
I = "{INERTIA} kg m^2"
b = "{VISCOUS} N m s/rad"

[dh]
convention = "modified"
rows = [["q", 0, 0, 0]]

[[joint]]
name = "arm"
link = {{ mass = "m", com = ["r", 0, 0], inertia = {{ about = "com", zz = "I" }} }}

[[effect]]
type = "viscous_friction"
at = "arm"
coefficient = "b"

[recording]
time = {{ column = "t", unit = "s" }}

[[recording.channel]]
column = "q"
quantity = "position"
joint = "arm"
unit = "rad"

[[recording.channel]]
column = "tau"
quantity = "effort"
joint = "arm"
unit = "N m"
"""


def pendulum(text: str = TOML) -> Robot:
    """The model: the pendulum with viscous friction, at its true parameters."""
    return robot_from_text(text, "pendulum.toml")


def motion(seed: int, time: Array, amplitude: float = 1.2) -> tuple[Array, Array, Array]:
    """Angle, speed and acceleration (N,) about an angle of -0.5 rad: a sum of sines, differentiated by hand."""
    rng = np.random.default_rng([seed, 0])
    omega = 2 * np.pi * 0.1 * HARMONICS
    weight = rng.uniform(0.4, 1.0, len(omega))
    weight *= amplitude / weight.sum()
    angle = np.outer(time, omega) + rng.uniform(0, 2 * np.pi, len(omega))
    return -0.5 + np.sin(angle) @ weight, np.cos(angle) @ (weight * omega), -np.sin(angle) @ (weight * omega**2)


def record(
    seed: int,
    missing: Torque | None = None,
    *,
    duration: float = 20.0,
    rate: float = 500.0,
    amplitude: float = 1.2,
    noise: bool = True,
) -> Recording:
    """What the sensors show; ``missing`` is a torque that the model does not know."""
    rng = np.random.default_rng([seed, 1])
    time = np.arange(round(duration * rate)) / rate
    q, v, a = motion(seed, time, amplitude)
    tau = TURNING * a + VISCOUS * v + MASS * GRAVITY * ARM * np.cos(q)
    if missing is not None:
        tau = tau + missing(time, q, v, a)
    random = rng.standard_normal((2, len(time))) * noise
    return recording(time, q + ANGLE_NOISE * random[0], tau + TORQUE_NOISE * random[1], f"run-{seed}")


def recording(time: Array, q: Array, tau: Array, name: str = "run", parts: tuple[slice, ...] = ()) -> Recording:
    """A recording of these samples, without gaps unless its ``parts`` are given."""
    channels = {(Quantity.POSITION, "arm", Side.LINK): q, (Quantity.EFFORT, "arm", Side.LINK): tau}
    whole = (slice(0, len(time)),)
    step = float(np.median(np.diff(time)))
    return Recording(name, time, MappingProxyType(channels), step, parts or whole, (), "0" * 64)
