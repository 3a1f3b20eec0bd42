"""The two-link arm: a plant in a vertical plane by hand-written equations, and the model of it that is handed over.

q1 from the horizontal x axis, q2 relative to link 1, gravity along -y (Spong, Hutchinson, Vidyasagar, "Robot Modeling
and Control", section 7.3). Midpoint rule at a fixed step; dry friction set-valued (``laws.hold``); a sampled PID
controller on encoder angles.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numba import njit

from benchmarks.blind import laws
from benchmarks.blind.machine import Machine, Place, Recorded, joint_channels, parameter_lines
from benchmarks.blind.motions import CONTROL, multisine, rng_of
from benchmarks.blind.planting import Planted, rows
from benchmarks.blind.sensors import LEVELS, analogue, encoder, faulty

GRAVITY, L1 = 9.81, 0.5
STEPS = 40  # of the integration per control sample
DURATION = 20.0  # s
CENTRE, REACH = np.array([-0.8, 0.3]), np.array([0.9, 1.2])
TORQUE = (16.0, 4.0)  # N m: full range of the torque sensors
TRUE = {
    "m_1": (1.08, "kg"), "m_2": (0.864, "kg"), "r_1": (0.25, "m"), "r_2": (0.2, "m"), "I_1": (0.022644, "kg m^2"),
    "I_2": (0.0116352, "kg m^2"), "b_1": (0.30, "N m s/rad"), "b_2": (0.12, "N m s/rad"),
}  # fmt: skip
PLACES = (Place("j1", "joint", 0.5, 1.6, 0.9, 10.0), Place("j2", "joint", 0.2, 2.2, 1.2, 2.4))

MODEL = """[robot]
name = "machine"
gravity = [0, {gravity}, 0]

[parameters]
l_1 = "0.5 m"
{parameters}

[dh]
convention = "modified"
rows = [ [ "q", 0, 0, 0 ], [ "q", 0, "l_1", 0 ] ]

[[joint]]
name = "j1"
link = {{ mass = "m_1", com = ["r_1", 0, 0], inertia = {{ about = "com", xx = 2e-4, yy = "I_1", zz = "I_1" }} }}

[[joint]]
name = "j2"
link = {{ mass = "m_2", com = ["r_2", 0, 0], inertia = {{ about = "com", xx = 2e-4, yy = "I_2", zz = "I_2" }} }}
{effects}
{channels}"""


class TwoLink(Machine):
    name = "two-link"
    places = PLACES
    truth = TRUE

    def record(
        self, planted: tuple[Planted, ...], true: Mapping[str, float], run: int, level: str, seed: int
    ) -> Recorded:
        rng = rng_of("two-link", run, level, seed)
        x, v = multisine(rng, run, DURATION, CENTRE + rng.uniform(-0.15, 0.15, 2), REACH)
        body = np.array([true[k] for k in ("m_1", "m_2", "r_1", "r_2", "I_1", "I_2")])
        p = rows(planted, self.places, [{"viscous": true["b_1"]}, {"viscous": true["b_2"]}])
        limit = np.array([self.plant_of(planted, place.address).get("effort_limit", math.inf) for place in self.places])
        sensors, columns = LEVELS[level], {}
        noise = sensors.encoder_noise * rng.standard_normal((len(x), 2))
        q, torque = _simulate(body, p, limit, GRAVITY, x, v, noise, STEPS)
        stride = sensors.stride
        for i, place in enumerate(self.places):
            shown = faulty(q[:, i], self.fault_of(planted, f"{place.address}.position"))
            columns[f"x{i + 1}"] = encoder(shown[::stride], sensors)
            columns[f"y{i + 1}"] = analogue(torque[::stride, i], TORQUE[i], sensors, rng)
        return Recorded(CONTROL * stride, columns)

    def model(self, given: Mapping[str, float], planted: tuple[Planted, ...], seed: int, form: bool = False) -> str:
        gone = {part for plant in planted for part in plant.omitted}
        own = {f"j{i}": f"b_{i}" for i in (1, 2) if f"viscous j{i}" not in gone}
        effects = [
            f'\n[[effect]]\ntype = "viscous_friction"\nat = "{at}"\ncoefficient = "{b}"\n' for at, b in own.items()
        ]
        return MODEL.format(
            gravity="0" if "gravity" in gone and not form else "-9.81",
            parameters=parameter_lines(self.truth, given, {"b_1", "b_2"} - set(own.values())),
            effects="".join(effects) + self.form_text(planted, form),
            channels=joint_channels(("j1", "j2"), "effort", "N m"),
        )


@njit(cache=True)
def _simulate(body, p, limit, gravity, reference, speeds, noise, steps):
    """Angles as the encoders show them and mean torques around the control samples, each (N, 2)."""
    count = len(reference)
    q, v = reference[0].copy(), speeds[0].copy()
    z, z_mid = np.zeros((2, laws.STATES)), np.zeros((2, laws.STATES))
    dry, levels = np.zeros(2), np.zeros((2, 2))
    angles, torques = np.empty((count, 2)), np.empty((count, 2))
    kp, ki, kd = np.array([260.0, 55.0]), np.array([900.0, 250.0]), np.array([16.0, 2.6])
    guess, mass, mass_mid = np.zeros(2), np.empty((2, 2)), np.empty((2, 2))
    _gravity(body, gravity, q, guess)
    total, last, filtered = 0.15 * guess, q.copy(), v.copy()
    torque, before = np.zeros(2), np.zeros(2)
    h = CONTROL / steps
    for k in range(count):
        seen = q + noise[k]
        _gravity(body, gravity, reference[k], guess)
        for i in range(2):
            filtered[i] += 0.25 * ((seen[i] - last[i]) / CONTROL - filtered[i])
            error = reference[k, i] - seen[i]
            total[i] += ki[i] * error * CONTROL
            torque[i] = kp[i] * error + total[i] + kd[i] * (speeds[k, i] - filtered[i]) + 0.85 * guess[i]
        if k == 0:
            before[:] = torque
        last[:] = seen
        angles[k], torques[k] = seen, 0.5 * (before + torque)
        before[:] = torque
        applied = np.minimum(np.maximum(torque, -limit), limit)
        for j in range(steps):
            t = k * CONTROL + j * h
            force = _force(body, gravity, p, q, v, t, z, applied)
            _mass(body, p, q, mass)
            middle = q + 0.5 * h * v
            v_mid = v + 0.5 * h * _solve(mass, force + dry)
            for i in range(2):
                laws.advance_states(p[i], v_mid[i], z[i], 0.5 * h, z_mid[i])
            force = _force(body, gravity, p, middle, v_mid, t + 0.5 * h, z_mid, applied)
            _mass(body, p, middle, mass_mid)
            after = v + h * _solve(mass_mid, force)
            for i in range(2):  # the load is what link and rotor need, of the step before
                levels[0, i], levels[1, i] = laws.dry_levels(p[i], q[i], v[i], applied[i] + dry[i])
            laws.hold(after, h * np.linalg.inv(mass_mid), levels[0], levels[1], dry)
            for i in range(2):
                laws.advance_states(p[i], 0.5 * (v[i] + after[i]), z[i], h, z_mid[i])
            z[:] = z_mid
            q += 0.5 * h * (v + after)
            v[:] = after
    return angles, torques


@njit(cache=True)
def _mass(body, p, q, out):
    m1, m2, r1, r2, i1, i2 = body
    c2 = math.cos(q[1])
    out[0, 0] = m1 * r1 * r1 + i1 + m2 * (L1 * L1 + r2 * r2 + 2 * L1 * r2 * c2) + i2 + p[0, laws.ADDED_INERTIA]
    out[0, 1] = out[1, 0] = m2 * (r2 * r2 + L1 * r2 * c2) + i2
    out[1, 1] = m2 * r2 * r2 + i2 + p[1, laws.ADDED_INERTIA]


@njit(cache=True)
def _gravity(body, gravity, q, out):
    m1, m2, r1, r2, _, _ = body
    out[1] = m2 * r2 * gravity * math.cos(q[0] + q[1])
    out[0] = (m1 * r1 + m2 * L1) * gravity * math.cos(q[0]) + out[1]


@njit(cache=True)
def _force(body, gravity, p, q, v, t, z, torque):
    """Everything but the mass matrix and dry friction."""
    h = body[1] * L1 * body[3] * math.sin(q[1])
    out = np.empty(2)
    _gravity(body, gravity, q, out)
    out[0] = torque[0] + h * v[1] * (2 * v[0] + v[1]) - out[0]
    out[1] = torque[1] - h * v[0] * v[0] - out[1]
    for i in range(2):
        out[i] += laws.smooth_force(p[i], q[i], v[i], t, z[i])
    return out


@njit(cache=True)
def _solve(mass, force):
    determinant = mass[0, 0] * mass[1, 1] - mass[0, 1] * mass[1, 0]
    out = np.empty(2)
    out[0] = (mass[1, 1] * force[0] - mass[0, 1] * force[1]) / determinant
    out[1] = (mass[0, 0] * force[1] - mass[1, 0] * force[0]) / determinant
    return out
