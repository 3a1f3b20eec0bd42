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
from benchmarks.blind.machine import Machine, Place, Recorded, effect_table, joint_channels, parameter_lines
from benchmarks.blind.motions import CONTROL, WIND_UP, multisine
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
PLACES = (Place("j1", "joint", 0.5, 1.6, 0.9, 10.0, -0.8), Place("j2", "joint", 0.2, 2.2, 1.2, 2.4, 0.3))

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
        rng = self.rng(planted, run, level, seed)
        x, v = multisine(rng, run, DURATION, CENTRE + rng.uniform(-0.15, 0.15, 2), REACH)
        body = np.array([true[k] for k in ("m_1", "m_2", "r_1", "r_2", "I_1", "I_2")])
        p = rows(planted, self.places, [{"viscous": true["b_1"]}, {"viscous": true["b_2"]}])
        limit = np.array([self.plant_of(planted, place.address).get("effort_limit", math.inf) for place in self.places])
        sensors, columns = LEVELS[level], {}
        noise = sensors.encoder_noise * rng.standard_normal((len(x), 2))
        q, torque = simulate(body, p, limit, GRAVITY, x, v, noise, STEPS)
        stride = sensors.stride
        for i, place in enumerate(self.places):
            shown = faulty(q[:, i], self.fault_of(planted, f"{place.address}.position"))
            columns[f"x{i + 1}"] = encoder(shown[::stride], sensors)
            shown = faulty(torque[:, i], self.fault_of(planted, "effort"))
            columns[f"y{i + 1}"] = analogue(shown[::stride], TORQUE[i], sensors, rng)
        return Recorded.even(CONTROL * stride, columns)

    def model(self, given: Mapping[str, float], planted: tuple[Planted, ...], seed: int, form: bool = False) -> str:
        gone = {part for plant in planted for part in plant.omitted}
        own = {f"j{i}": f"b_{i}" for i in (1, 2) if f"viscous j{i}" not in gone}
        effects = [effect_table("viscous_friction", at, {"coefficient": f'"{b}"'}) for at, b in own.items()]
        return MODEL.format(
            gravity="0" if "gravity" in gone and not form else "-9.81",
            parameters=parameter_lines(self.truth, given, {"b_1", "b_2"} - set(own.values())),
            effects="".join(effects) + self.form_text(planted, form),
            channels=joint_channels(("j1", "j2"), "effort", "N m"),
        )


@njit  # without cache: Numba would not see that the laws it inlines have changed
def simulate(body, p, limit, gravity, reference, speeds, noise, steps):
    """Angles as the encoders show them and mean torques around the control samples, each (N, 2)."""
    count = len(reference)
    q, v, q_mid, v_mid, after = np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(2)
    z, z_mid = np.zeros((2, laws.STATES)), np.zeros((2, laws.STATES))
    dry, forwards, backwards, mobility = np.zeros(2), np.zeros(2), np.zeros(2), np.zeros((2, 2))
    total, last, filtered = np.zeros(2), np.zeros(2), np.zeros(2)
    torque, before, applied = np.zeros(2), np.zeros(2), np.zeros(2)
    angles, torques = np.zeros((count, 2)), np.zeros((count, 2))
    kp, ki, kd = (260.0, 55.0), (900.0, 250.0), (16.0, 2.6)
    guess, force = np.zeros(2), np.zeros(2)
    _gravity(body, gravity, reference[0], guess)
    for i in range(2):
        q[i], v[i], last[i], filtered[i] = reference[0, i], speeds[0, i], reference[0, i], speeds[0, i]
        total[i] = 0.15 * guess[i]
        z[i, laws.LOAD_SPEED] = speeds[0, i]
    h = CONTROL / steps
    for k in range(count):
        _gravity(body, gravity, reference[k], guess)
        for i in range(2):
            seen = q[i] + noise[k, i]
            filtered[i] += 0.25 * ((seen - last[i]) / CONTROL - filtered[i])
            error = reference[k, i] - seen
            if abs(error) < WIND_UP:
                total[i] += ki[i] * error * CONTROL
            torque[i] = kp[i] * error + total[i] + kd[i] * (speeds[k, i] - filtered[i]) + 0.85 * guess[i]
            angles[k, i], last[i] = seen, seen
            torques[k, i] = 0.5 * (torque[i] + (before[i] if k > 0 else torque[i]))
            before[i] = torque[i]
            applied[i] = min(max(torque[i], -limit[i]), limit[i])
        for j in range(steps):
            t = k * CONTROL + j * h
            _force(body, gravity, p, q, v, t, z, applied, force)
            _mobility(body, p, q, 0.5 * h, mobility)
            for i in range(2):
                q_mid[i] = q[i] + 0.5 * h * v[i]
                v_mid[i] = v[i] + mobility[i, 0] * (force[0] + dry[0]) + mobility[i, 1] * (force[1] + dry[1])
                laws.advance_states(p[i], v_mid[i], z[i], 0.5 * h, z_mid[i])
                # the load is what link, rotor and springs need: no friction; of the step before
                load = applied[i] + dry[i] + laws.drag(p[i], v_mid[i])
                forwards[i], backwards[i] = laws.dry_levels(p[i], q_mid[i], v_mid[i], load)
            _force(body, gravity, p, q_mid, v_mid, t + 0.5 * h, z_mid, applied, force)
            _mobility(body, p, q_mid, h, mobility)
            for i in range(2):
                after[i] = v[i] + mobility[i, 0] * force[0] + mobility[i, 1] * force[1]
            laws.hold(after, mobility, forwards, backwards, dry)
            for i in range(2):
                laws.advance_states(p[i], 0.5 * (v[i] + after[i]), z[i], h, z_mid[i])
                z[i] = z_mid[i]
                q[i] += 0.5 * h * (v[i] + after[i])
                v[i] = after[i]
    return angles, torques


@njit
def _mobility(body, p, q, h, out):
    """Change of speed per force over a time ``h``: that times the inverse of the mass matrix."""
    m1, m2, r1, r2, i1, i2 = body
    c2 = math.cos(q[1])
    m11 = m1 * r1 * r1 + i1 + m2 * (L1 * L1 + r2 * r2 + 2 * L1 * r2 * c2) + i2 + p[0, laws.ADDED_INERTIA]
    m12 = m2 * (r2 * r2 + L1 * r2 * c2) + i2
    m22 = m2 * r2 * r2 + i2 + p[1, laws.ADDED_INERTIA]
    scale = h / (m11 * m22 - m12 * m12)
    out[0, 0], out[1, 1] = scale * m22, scale * m11
    out[0, 1] = out[1, 0] = -scale * m12


@njit
def _gravity(body, gravity, q, out):
    m1, m2, r1, r2, _, _ = body
    out[1] = m2 * r2 * gravity * math.cos(q[0] + q[1])
    out[0] = (m1 * r1 + m2 * L1) * gravity * math.cos(q[0]) + out[1]


@njit
def _force(body, gravity, p, q, v, t, z, torque, out):
    """Everything but the mass matrix and dry friction."""
    h = body[1] * L1 * body[3] * math.sin(q[1])
    _gravity(body, gravity, q, out)
    out[0] = torque[0] + h * v[1] * (2 * v[0] + v[1]) - out[0]
    out[1] = torque[1] - h * v[0] * v[0] - out[1]
    for i in range(2):
        out[i] += laws.smooth_force(p[i], q[i], v[i], t, z[i])
