"""An arm behind a soft gear, which its weight bends: hand-written equations, and the model that is handed over.

A servo on the motor's angle commands a torque, which is recorded as it is commanded, at the motor. The motor has an
encoder; the arm has one in every other case. The recording begins in motion, the gear bent by the arm's weight.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numba import njit

from benchmarks.blind import laws
from benchmarks.blind.chain import CLEARANCE, MU, SHAFT, across, loop_rate
from benchmarks.blind.effects import GRAVITY
from benchmarks.blind.machine import Machine, Place, Recorded, parameter_lines
from benchmarks.blind.motions import CONTROL, multisine
from benchmarks.blind.planting import Planted, rows
from benchmarks.blind.sensors import LEVELS, analogue, encoder

RATIO = 30.0
STEPS = 50  # of the integration per control sample: the gear's poles are below 200 1/s
DURATION = 12.0  # s
CENTRE, REACH = -0.4, 0.8  # rad, of the arm: level at 0
TORQUE, DITHER = 0.5, 0.02  # N m at the motor: full range, and a random step every 20 ms
GAINS = (0.08, 0.1, 0.013)  # N m/rad, N m/(rad s), N m s/rad of the servo
TRUTH = {
    "m": (3.0, "kg"), "a": (0.3, "m"), "J_a": (0.04, "kg m^2"), "J_m": (200e-6, "kg m^2"),
    "c": (0.9, "N m/rad"), "d": (900e-6, "N m s/rad"), "b": (800e-6, "N m s/rad"),
}  # fmt: skip

MODEL = """[robot]
name = "machine"
gravity = [0, "-9.81 m/s^2", 0]

[parameters]
{parameters}

[dh]
rows = [ [ "q", 0, 0, 0 ] ]

[[joint]]
name = "j1"
link = {{ mass = "m", com = [ "a", 0, 0 ], inertia = {{ about = "com", zz = "J_a" }} }}

[joint.drive]
ratio = 30
rotors = [ {{ name = "motor", inertia = "J_m" }} ]
shafts = [ {{ name = "gear", from = "motor", to = "joint", stiffness = "c", damping = "d" }} ]
effort_at = "motor"
{friction}{form}
[recording]
time = {{ column = "t", unit = "s" }}

[[recording.channel]]
column = "y"
quantity = "effort"
joint = "j1"
side = "motor"
unit = "N m"

[[recording.channel]]
column = "x"
quantity = "position"
joint = "j1.motor"
unit = "rad"
"""
OUTPUT = """
[[recording.channel]]
column = "z"
quantity = "position"
joint = "j1"
unit = "rad"
"""
FRICTION = '\n[[effect]]\ntype = "viscous_friction"\nat = "j1.motor"\ncoefficient = "b"\n'


class GearedArm(Machine):
    name = "geared-arm"
    truth = TRUTH
    places = (
        Place("j1.motor", "inertia", 0.02, 40.0, RATIO * REACH),
        Place("j1", "joint", 0.6, 1.4, REACH, centre=CENTRE),
        Place("j1.gear", "shaft", 0.03, 1.0, 0.1),
    )

    def record(
        self, planted: tuple[Planted, ...], true: Mapping[str, float], run: int, level: str, seed: int
    ) -> Recorded:
        rng = self.rng(planted, run, level, seed)
        reference, speeds = multisine(rng, run, DURATION, np.array([CENTRE]), np.array([REACH]))
        shaft = {**dict.fromkeys(SHAFT, 0.0), **self.plant_of(planted, "j1.gear")}
        sensors = LEVELS[level]
        noise = sensors.encoder_noise * rng.standard_normal((2, len(reference)))
        torque, angle, output = simulate(
            np.array([true[name] for name in TRUTH]),
            np.array([shaft[name] for name in SHAFT]),
            rows(planted, self.places, [{"viscous": true["b"]}, {}]),
            reference[:, 0],
            speeds[:, 0],
            np.repeat(rng.choice((-DITHER, DITHER), len(reference) // 20 + 1), 20)[: len(reference)],
            noise[0],
            sensors.stride,
        )
        every = slice(None, None, sensors.stride)
        columns = {
            "y": analogue(torque[every], TORQUE, sensors, rng),
            "x": encoder(angle[every], sensors),
            "z": encoder((output + noise[1])[every], sensors),
        }
        return Recorded.even(CONTROL * sensors.stride, {name: columns[name] for name in ("yx" if seed % 2 else "yxz")})

    def model(self, given: Mapping[str, float], planted: tuple[Planted, ...], seed: int, form: bool = False) -> str:
        gone = any("viscous j1.motor" in plant.omitted for plant in planted)
        parameters = parameter_lines(TRUTH, given, {"b"} if gone else set())
        friction = "" if gone else FRICTION
        text = MODEL.format(parameters=parameters, friction=friction, form=self.form_text(planted, form))
        return text + ("" if seed % 2 else OUTPUT)


@njit  # without cache: Numba would not see that the laws it inlines have changed
def simulate(true, shaft, p, reference, speeds, dither, noise, stride):
    """Torque, motor angle and arm angle at the control samples, each (N); midpoint rule, dry friction set-valued.

    The servo acts at every ``stride``-th of them.
    """
    m, a, inertia, rotor = true[0], true[1], true[2], true[3]
    weight, count, h = m * GRAVITY * a, len(reference), CONTROL / STEPS
    masses = np.array([rotor, inertia + m * a * a])
    mobility = np.zeros((2, 2))
    for i in range(2):
        mobility[i, i] = h / masses[i]
    held = weight * math.cos(reference[0]) / RATIO
    x = np.array([RATIO * reference[0] + held / true[4] + shaft[CLEARANCE], reference[0]])
    v = np.array([RATIO * speeds[0], speeds[0]])
    z, z_mid = np.zeros((2, laws.STATES)), np.zeros((2, laws.STATES))
    dry, forwards, backwards = np.zeros(2), np.zeros(2), np.zeros(2)
    torques, angles, outputs = np.empty(count), np.empty(count), np.empty(count)
    loop, total, filtered, torque = 0.0, 0.0, v[0], 0.0
    last = x[0]
    for k in range(count):
        seen = x[0] + noise[k]
        if k % stride == 0:  # the servo's own sample: the torque is held from here to the next
            period = stride * CONTROL
            if k:
                filtered += 0.3 * ((seen - last) / period - filtered)
            last = seen
            error = RATIO * reference[k] - seen
            total += error * period
            torque = GAINS[0] * error + GAINS[1] * total + GAINS[2] * (RATIO * speeds[k] - filtered) + dither[k]
            torque += weight * math.cos(reference[k]) / RATIO
        torques[k], angles[k], outputs[k] = torque, seen, x[1]
        for j in range(STEPS):
            t = k * CONTROL + j * h
            force, _ = _forces(true, shaft, p, x, v, t, z, loop, torque)
            x_mid, v_mid = x + 0.5 * h * v, v + 0.5 * h * (force + dry) / masses
            for i in range(2):
                laws.advance_states(p[i], v_mid[i], z[i], 0.5 * h, z_mid[i])
            rate = RATIO * v[1] - v[0]
            loop_mid = loop + 0.5 * h * loop_rate(shaft, rate, loop)
            force, load = _forces(true, shaft, p, x_mid, v_mid, t + 0.5 * h, z_mid, loop_mid, torque)
            after = v + h * force / masses
            for i in range(2):
                forwards[i], backwards[i] = laws.dry_levels(p[i], x_mid[i], v_mid[i], load)
            forwards[0] += shaft[MU] * abs(load)
            backwards[0] += shaft[MU] * abs(load)
            laws.hold(after, mobility, forwards, backwards, dry)
            loop += h * loop_rate(shaft, rate, loop_mid)
            for i in range(2):
                laws.advance_states(p[i], 0.5 * (v[i] + after[i]), z[i], h, z_mid[i])
            z[:] = z_mid
            x += 0.5 * h * (v + after)
            v[:] = after
    return torques, angles, outputs


@njit
def _forces(true, shaft, p, x, v, t, z, loop, torque):
    """Forces on motor and arm, dry friction left out, and the torque that the gear transmits, at the motor's side."""
    force = np.empty(2)
    for i in range(2):
        force[i] = laws.smooth_force(p[i], x[i], v[i], t, z[i])
    twist, rate = RATIO * x[1] - x[0], RATIO * v[1] - v[0]
    through, slope = across(shaft, true[4], true[5], twist, rate, x[0], v[0], loop)
    force[0] += torque + through * (1.0 + slope)
    force[1] -= RATIO * through + true[0] * GRAVITY * true[1] * math.cos(x[1])
    return force, through
