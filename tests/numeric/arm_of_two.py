"""A planar arm with two joints, its torques written by hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Side

from .pendulum import GRAVITY

HARMONICS = 2 * np.pi * 0.1 * np.array([1, 2, 3, 5, 7])
M1, M2, R1, R2, L1, I1, I2 = 1.0, 0.8, 0.2, 0.15, 0.4, 0.02, 0.01

ARM_OF_TWO = f"""
[robot]
name = "two"
gravity = [0, -{GRAVITY}, 0]

[parameters]
m1 = "1.1 kg"
m2 = "0.7 kg"
r1 = "0.22 m"
r2 = "0.14 m"
I1 = "0.024 kg m^2"
I2 = "0.009 kg m^2"
b1 = "0.2 N m s/rad"
b2 = "0.1 N m s/rad"

[dh]
convention = "modified"
rows = [["q", 0, 0, 0], ["q", 0, {L1}, 0]]

[[joint]]
name = "one"
link = {{ mass = "m1", com = ["r1", 0, 0], inertia = {{ about = "com", zz = "I1" }} }}

[[joint]]
name = "two"
link = {{ mass = "m2", com = ["r2", 0, 0], inertia = {{ about = "com", zz = "I2" }} }}

[[effect]]
type = "viscous_friction"
at = "one"
coefficient = "b1"

[[effect]]
type = "viscous_friction"
at = "two"
coefficient = "b2"
"""


def with_drives(drives: Mapping[str, str]) -> str:
    """The arm with a [joint.drive] table after the link of each joint that is named."""
    text = ARM_OF_TWO
    for name, drive in drives.items():
        bare = f'[[joint]]\nname = "{name}"\n'
        before, after = text.split(bare)
        link, rest = after.split("\n", 1)
        text = f"{before}{bare}{link}\n\n[joint.drive]\n{drive}{rest}"
    return text


def rubbing(seed: int, level: float) -> Recording:
    """A run with Coulomb friction at the second joint."""
    plain = run(seed)
    speed = np.gradient(plain.channels[Quantity.POSITION, "two", Side.LINK], plain.time)
    effort = plain.channels[Quantity.EFFORT, "two", Side.LINK] + level * np.tanh(speed / 1e-3)
    return replace(plain, channels=MappingProxyType({**plain.channels, (Quantity.EFFORT, "two", Side.LINK): effort}))


def run(
    seed: int,
    gain: float = 1.0,
    offset: float = 0.0,
    first: float = 0.0,
    rotor: float = 0.0,
    by_load: float = 0.0,
    shown: tuple[float, float] = (1.0, 1.0),
    carried: tuple[float, float, float] = (0.0, 0.0, 0.0),
    mounted: tuple[float, float, float] = (0.0, 0.0, 0.0),
    shaken: float = 0.0,
) -> Recording:
    """A planar arm along sums of sines, its torques written by hand.

    The second encoder shows gain q + offset, the first one q + ``first``. The second joint has a ``rotor``, the first
    one friction by load. Torques are ``shown`` times what they are. The second link has ``carried``, the first
    one ``mounted``: (mass, x, y).
    The second joint shakes at 8 Hz, by ``shaken`` rad.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(10_000) / 500.0
    q, v, a = np.empty((3, len(t), 2))
    for j in range(2):
        weight = rng.uniform(0.4, 1.0, len(HARMONICS))
        angle = np.outer(t, HARMONICS) + rng.uniform(0, 2 * np.pi, len(HARMONICS))
        weight *= 1.1 / weight.sum()
        q[:, j], v[:, j] = np.sin(angle) @ weight - 0.4, np.cos(angle) @ (weight * HARMONICS)
        a[:, j] = -np.sin(angle) @ (weight * HARMONICS**2)
    quick = 2 * np.pi * 8.0
    q[:, 1] += shaken * np.sin(quick * t)
    v[:, 1] += shaken * quick * np.cos(quick * t)
    a[:, 1] -= shaken * quick**2 * np.sin(quick * t)
    c, h = np.cos(q[:, 1]), M2 * L1 * R2 * np.sin(q[:, 1])
    mass, reach, turn = carried[0], np.hypot(*carried[1:]), np.arctan2(carried[2], carried[1])
    lever, sideways = L1 * reach * np.cos(q[:, 1] + turn), L1 * reach * np.sin(q[:, 1] + turn)
    m11 = M1 * R1**2 + I1 + M2 * (L1**2 + R2**2 + 2 * L1 * R2 * c) + I2
    m12, m22 = M2 * (R2**2 + L1 * R2 * c) + I2, M2 * R2**2 + I2
    m11, m12 = m11 + mass * (L1**2 + reach**2 + 2 * lever), m12 + mass * (reach**2 + lever)
    m22, h = m22 + mass * reach**2, h + mass * sideways
    g2 = GRAVITY * (M2 * R2 * np.cos(q.sum(axis=1)) + mass * reach * np.cos(q.sum(axis=1) + turn))
    g1 = (M1 * R1 + (M2 + mass) * L1) * GRAVITY * np.cos(q[:, 0]) + g2
    piece, x, y = mounted
    m11 = m11 + piece * (x**2 + y**2)
    g1 = g1 + piece * GRAVITY * (x * np.cos(q[:, 0]) - y * np.sin(q[:, 0]))
    load = m11 * a[:, 0] + m12 * a[:, 1] - h * v[:, 1] * (2 * v[:, 0] + v[:, 1]) + g1
    tau1 = load + by_load * np.abs(load) * np.sign(v[:, 0]) + 0.3 * v[:, 0]
    tau2 = m12 * a[:, 0] + (m22 + rotor) * a[:, 1] + h * v[:, 0] ** 2 + g2 + 0.12 * v[:, 1]
    channels = {
        (Quantity.POSITION, "one", Side.LINK): q[:, 0] + first + 5e-6 * rng.standard_normal(len(t)),
        (Quantity.POSITION, "two", Side.LINK): gain * q[:, 1] + offset + 5e-6 * rng.standard_normal(len(t)),
        (Quantity.EFFORT, "one", Side.LINK): shown[0] * tau1 + 0.02 * rng.standard_normal(len(t)),
        (Quantity.EFFORT, "two", Side.LINK): shown[1] * tau2 + 0.01 * rng.standard_normal(len(t)),
    }
    return Recording(f"run-{seed}", t, MappingProxyType(channels), 1 / 500.0, (slice(0, len(t)),), (), "0" * 64)
