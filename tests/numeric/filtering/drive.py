"""A drive with hidden parts, and recordings of it by equations written here: nothing of symdyn computes them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Robot

Array = NDArray[np.float64]

MODEL = """
[robot]
name = "drive"
gravity = [0, 0, 0]

[parameters]
R = "1.8 Ohm"
L = "0.4 mH"
K_T = "0.08 N m/A"
K_E = "0.08 V s/rad"
J_m = "7e-5 kg m^2"
J_l = "4e-4 kg m^2"
b = "2.5e-4 N m s/rad"

[dh]
rows = [ [ "q", 0, 0, 0 ] ]

[[joint]]
name = "axis"
link = { inertia = { about = "joint", zz = "J_l" } }

[joint.drive]
ratio = 1
rotors = [ { name = "motor", inertia = "J_m", fixed_to_joint = true } ]

[joint.drive.motor]
name = "circuit"
at = "motor"
resistance = "R"
inductance = "L"
torque_constant = "K_T"
back_emf_constant = "K_E"

[[effect]]
type = "viscous_friction"
at = "axis"
coefficient = "b"

[[effect]]
type = "tachometer"
at = "axis.motor"
constant = "0.03 V s/rad"

[recording]
time = { column = "t", unit = "s" }
[[recording.channel]]
column = "u"
quantity = "voltage"
joint = "axis"
unit = "V"
[[recording.channel]]
column = "i"
quantity = "current"
joint = "axis"
unit = "A"
[[recording.channel]]
column = "x"
quantity = "position"
joint = "axis"
side = "motor"
unit = "rad"
[[recording.channel]]
column = "w"
quantity = "voltage"
joint = "axis.motor"
unit = "V"
"""

R, L, K_T, K_E, J_M, J_L, B, K_W = 1.6, 0.4e-3, 0.085, 0.08, 8e-5, 3.5e-4, 3e-4, 0.03  # the truth
TRUE = {
    "R": f"{R} Ohm", "L": f"{L} H", "K_T": f"{K_T} N m/A", "K_E": f"{K_E} V s/rad",
    "J_m": f"{J_M} kg m^2", "J_l": f"{J_L} kg m^2", "b": f"{B} N m s/rad",
}  # fmt: skip
STEP, FINE, DURATION = 2e-3, 100, 6.0


@dataclass(frozen=True)
class Concealed:
    """What the model lacks, each zero where it is absent."""

    coulomb: float = 0.0  # N m
    stiffness: float = 0.0  # N m/rad of a transmission, which is rigid without
    dahl: float = 0.0  # N m, reached over the distance
    distance: float = 0.05  # rad
    shape: float = 1.0  # of that loop: below 1 it is Bouc-Wen's, which unloads less steeply than loading began
    unbalance: float = 0.0  # N m at the most, which hangs at rest at the angle 0
    push: float = 0.0  # N m, always the same way
    spring: float = 0.0  # N m/rad, to the angle 0
    hardening: float = 0.0  # N m/rad^3, to the angle 0
    gusts: float = 0.0  # N m at the most, a tenth of a second each, when nothing of the machine's own calls for them
    late: float = 0.0  # s, of the voltage behind its command
    offset: float = 0.0  # A, of the ammeter
    lag: float = 0.0  # s, of the tachometer
    bias: float = 0.0  # V, that the amplifier adds to its command
    dead: float = 0.0  # V, by which its output falls short of that


def record(
    path: Path, robot: Robot, seed: int, applied_voltage: Array | None = None, size: float = 1.0, **concealed: float
) -> Recording:
    """Leapfrog at 20 us: speeds are those of half steps. Dry friction brakes to a stop within a step, and never beyond.

    The voltage is ``applied_voltage`` (N,), or waves of that ``size``.
    """
    c = Concealed(**concealed)
    rng = np.random.default_rng(seed)
    count = round(DURATION / STEP) if applied_voltage is None else len(applied_voltage)
    time = np.arange(count) * STEP
    waves = [
        (a, f, rng.uniform(0, 2 * np.pi)) for a, f in ((2.0, 0.5), (2.0, 1.3), (1.5, 2.9), (1.0, 6.1), (1.0, 12.7))
    ]
    u = size * sum(a * np.sin(2 * np.pi * f * time + phase) for a, f, phase in waves)
    if applied_voltage is not None:
        u = applied_voltage
    h = STEP / FINE
    current, x, v, load, load_speed, bristle, shown = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    table = np.zeros((count, 3))
    inertia = J_M if c.stiffness else J_M + J_L
    behind = round(c.late / h)
    gust = c.gusts * np.repeat(rng.uniform(-1.0, 1.0, round(DURATION / 0.1)), round(0.1 / STEP)) if c.gusts else 0.0 * u
    for k in range(count):
        table[k] = current, x, shown
        for j in range(FINE):
            before = v
            twist = c.stiffness * (x - load) + 2e-3 * (v - load_speed) if c.stiffness else 0.0
            held = c.unbalance * np.sin(x) + c.spring * x + c.hardening * x**3
            torque = K_T * current + c.push + gust[k] - c.dahl * bristle - held
            v += h / inertia * (torque - (twist if c.stiffness else B * v))
            dry = c.coulomb * h / inertia
            v = np.sign(v) * max(abs(v) - dry, 0.0)
            if j == 0 and not c.lag:
                table[k, 2] = 0.5 * (before + v)
            applied = u[max(k * FINE + j - behind, 0) // FINE] + c.bias
            applied = np.sign(applied) * max(abs(applied) - c.dead, 0.0)
            current += h / L * (applied - K_E * v - R * current) / (1.0 + 0.5 * h * R / L)
            back = (1.0 - c.shape) * (abs(v) * bristle - v * abs(bristle)) * h / c.distance
            bristle += back - (np.sign(v) - bristle) * np.expm1(-abs(v) * h / c.distance)
            load_speed += h / J_L * (twist - B * load_speed)  # the model's drag is at the joint
            x, load = x + h * v, load + h * load_speed
            shown += h / c.lag * (v - shown) if c.lag else 0.0
    noisy = np.column_stack(
        [
            time,
            u,
            table[:, 0] + c.offset + rng.normal(0, 0.02, count),
            np.round(table[:, 1] / 1e-4) * 1e-4,
            K_W * table[:, 2] + rng.normal(0, 5e-3, count),
        ]
    )
    np.savetxt(path, noisy, delimiter=",", header="t,u,i,x,w", comments="", fmt="%.9g")
    assert robot.channels is not None
    return read_recording(path, robot.channels)
