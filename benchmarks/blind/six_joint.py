"""The six-joint arm: a plant in MuJoCo with generalised forces of our own, and the model of it that is handed over.

Geometry and masses of a Puma 560 (Armstrong, Khatib, Burdick 1986), its moments of inertia made rounder, so that those
of every draw are a body's; motors of reflected inertia, viscous and dry friction at every joint. MuJoCo integrates the
arm, its armature and its dry friction, whose level is set at every step; all other laws are those of ``laws``, applied
as generalised forces.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numba import njit

from benchmarks.blind import laws
from benchmarks.blind.machine import Machine, Place, Recorded, joint_channels, parameter_lines
from benchmarks.blind.motions import CONTROL, WIND_UP, multisine
from benchmarks.blind.planting import Planted, rows
from benchmarks.blind.sensors import LEVELS, analogue, encoder, faulty

STEPS = 4  # of MuJoCo per control sample
DURATION = 30.0  # s
HALF_TURN = math.pi / 2
DH = (  # d, a, alpha (standard)
    (0.67, 0.0, HALF_TURN), (0.0, 0.4318, 0.0), (0.15, 0.0203, -HALF_TURN), (0.4318, 0.0, HALF_TURN),
    (0.0, 0.0, -HALF_TURN), (0.0, 0.0, 0.0),
)  # fmt: skip
MASS = (0.0, 17.4, 4.8, 0.82, 0.34, 0.09)
COM = ((0, 0, 0), (-0.3638, 0.006, 0.2275), (-0.0203, -0.0141, 0.07), (0, 0.019, 0), (0, 0, 0), (0, 0, 0.032))
INERTIA = (  # xx, yy, zz about the centre of mass, in the frame of the link
    (0.0, 0.35, 0.0), (0.25, 0.5, 0.5), (0.05, 0.05, 0.03), (1.8e-3, 1.3e-3, 1.8e-3), (3e-4, 4e-4, 3e-4),
    (1.5e-4, 1.5e-4, 8e-5),
)  # fmt: skip
ARMATURE = (0.78, 2.32, 0.58, 0.19, 0.17, 0.19)
VISCOUS = (5.8, 9.5, 4.0, 0.41, 0.43, 0.22)
DRY = (10.0, 8.0, 5.0, 1.1, 0.9, 0.55)
GAIN = (10.0, 15.0, 8.0, 2.0, 2.0, 1.5)  # N m/A
CENTRE = np.array([0.2, 0.8, -0.3, 0.1, 0.5, 0.0])
REACH = np.array([0.9, 0.6, 0.7, 1.0, 0.9, 1.2])
CURRENT = (6.0, 8.0, 6.0, 2.0, 2.0, 2.0)  # A: full range of the current sensors
JOINTS = tuple(f"j{i}" for i in range(1, 7))
_FORCES = (6.0, 10.0, 4.5, 0.6, 0.5, 0.35)
_PEAKS = (50.0, 72.0, 21.0, 3.4, 3.1, 2.8)
PLACES = tuple(
    Place(joint, "joint", force, 1.6 * float(reach), float(reach), peak, float(centre))
    for joint, force, reach, peak, centre in zip(JOINTS, _FORCES, REACH, _PEAKS, CENTRE, strict=True)
)


def _nominal() -> dict[str, tuple[float, str]]:
    found: dict[str, tuple[float, str]] = {}
    for i in range(6):
        for axis, value in zip("xyz", COM[i], strict=True):
            if value:
                found[f"c{axis}_{i + 1}"] = (float(value), "m")
        for axis, value in zip("xyz", INERTIA[i], strict=True):
            if value:
                found[f"I{axis}_{i + 1}"] = (value, "kg m^2")
        if MASS[i]:
            found[f"m_{i + 1}"] = (MASS[i], "kg")
        found[f"J_{i + 1}"] = (ARMATURE[i], "kg m^2")
        found[f"b_{i + 1}"] = (VISCOUS[i], "N m s/rad")
        found[f"F_{i + 1}"] = (DRY[i], "N m")
    return found


class SixJoint(Machine):
    name = "six-joint"
    places = PLACES
    truth = _nominal()

    def record(
        self, planted: tuple[Planted, ...], true: Mapping[str, float], run: int, level: str, seed: int
    ) -> Recorded:
        rng = self.rng(planted, run, level, seed)
        x, v = multisine(rng, run, DURATION, CENTRE + rng.uniform(-0.15, 0.15, 6), REACH)
        own = [
            {"viscous": true[f"b_{i}"], "level_positive": true[f"F_{i}"], "level_negative": true[f"F_{i}"]}
            for i in range(1, 7)
        ]
        p = rows(planted, self.places, own)
        limit = np.array([self.plant_of(planted, place.address).get("effort_limit", math.inf) for place in self.places])
        sensors, columns = LEVELS[level], {}
        noise = sensors.encoder_noise * rng.standard_normal((len(x), 6))
        angles, torques = _simulate(true, p, limit, x, v, noise)
        for i, place in enumerate(self.places):
            shown = faulty(angles[:, i], self.fault_of(planted, f"{place.address}.position"))
            columns[f"x{i + 1}"] = encoder(shown[:: sensors.stride], sensors)
            shown = faulty(torques[:, i], self.fault_of(planted, "effort")) / GAIN[i]
            columns[f"y{i + 1}"] = analogue(shown[:: sensors.stride], CURRENT[i], sensors, rng)
        return Recorded.even(CONTROL * sensors.stride, columns)

    def model(self, given: Mapping[str, float], planted: tuple[Planted, ...], seed: int, form: bool = False) -> str:
        gone = {part for plant in planted for part in plant.omitted}
        text = '[robot]\nname = "machine"\n'
        text += f"gravity = [0, 0, {'0' if 'gravity' in gone and not form else '-9.81'}]\n\n[parameters]\n"
        left_out = {f"{'F' if part.startswith('dry') else 'b'}_{part[-1]}" for part in gone if part != "gravity"}
        text += parameter_lines(self.truth, given, left_out)
        table = ",\n".join(f'  ["q", {d}, {a}, "{math.degrees(alpha):.0f} deg"]' for d, a, alpha in DH)
        text += f"\n\n[dh]\nrows = [\n{table} ]\n"
        for i, joint in enumerate(JOINTS, 1):
            text += f'\n[[joint]]\nname = "{joint}"\nlink = {{ {self._link(i)} }}\n'
            text += f'actuator = {{ gain = "{GAIN[i - 1]} N m/A" }}\n'
        for i, joint in enumerate(JOINTS, 1):
            laws_of = (
                ("added_inertia", "inertia", "J"),
                ("viscous_friction", "coefficient", "b"),
                ("coulomb_friction", "level", "F"),
            )
            for effect, name, letter in laws_of:
                if f"{letter}_{i}" not in left_out:
                    text += f'\n[[effect]]\ntype = "{effect}"\nat = "{joint}"\n{name} = "{letter}_{i}"\n'
        return text + self.form_text(planted, form) + joint_channels(JOINTS, "current", "A")

    def _link(self, i: int) -> str:
        parts = [f'mass = "m_{i}"'] if MASS[i - 1] else []
        if MASS[i - 1]:
            com = ", ".join(f'"c{axis}_{i}"' if value else "0" for axis, value in zip("xyz", COM[i - 1], strict=True))
            parts.append(f"com = [{com}]")
        inertia = ", ".join(f'{a}{a} = "I{a}_{i}"' for a, value in zip("xyz", INERTIA[i - 1], strict=True) if value)
        return ", ".join([*parts, f"inertia = {{ {inertia} }}"])


def _rest(i: int) -> tuple[np.ndarray, np.ndarray]:
    """Position and rotation of the frame behind row i of the table, at q = 0, in the frame before it."""
    d, a, alpha = DH[i]
    c, s = math.cos(alpha), math.sin(alpha)
    return np.array([a, 0.0, d]), np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def _quaternion(i: int) -> str:
    half = DH[i][2] / 2
    return f"{math.cos(half):.17g} {math.sin(half):.17g} 0 0"


def mjcf(true: Mapping[str, float], added: np.ndarray) -> str:
    """The arm in MuJoCo's language; a body turns about the z axis of the frame before, its frame not yet moved on."""
    text, close = "", ""
    for i in range(6):
        position, rotation = _rest(i)
        com = position + rotation @ np.array([true.get(f"c{axis}_{i + 1}", 0.0) for axis in "xyz"])
        moments = np.diag([true.get(f"I{axis}_{i + 1}", 0.0) for axis in "xyz"])
        if i == 0:  # only what the waist feels is known: a body needs more
            moments = true["Iy_1"] * np.diag([0.6, 1.0, 0.6])
        tensor = rotation @ moments @ rotation.T
        full = [tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2]]
        where = "" if i == 0 else f'pos="{" ".join(f"{x:.17g}" for x in _rest(i - 1)[0])}" quat="{_quaternion(i - 1)}"'
        armature = true[f"J_{i + 1}"] + added[i]
        text += (
            f'<body {where}><joint type="hinge" axis="0 0 1" armature="{armature:.17g}" frictionloss="1"/>'
            f'<inertial mass="{true.get(f"m_{i + 1}", 1.0):.17g}" pos="{" ".join(f"{x:.17g}" for x in com)}" '
            f'fullinertia="{" ".join(f"{x:.17g}" for x in full)}"/>'
        )
        close += "</body>"
    option = f'<option gravity="0 0 -9.81" timestep="{CONTROL / STEPS}" integrator="implicitfast" tolerance="1e-12"/>'
    solver = '<default><joint solreffriction="0.001 1" solimpfriction="0.9999 0.9999 0.001"/></default>'
    return (
        f'<mujoco><compiler angle="radian" balanceinertia="false" boundinertia="1e-9"/>{option}{solver}'
        f"<worldbody>{text}{close}</worldbody></mujoco>"
    )


def _simulate(
    true: Mapping[str, float], p: np.ndarray, limit: np.ndarray, x: np.ndarray, v: np.ndarray, noise: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Angles as the encoders show them and mean torques around the control samples, each (N, 6)."""
    import mujoco

    model: Any = mujoco.MjModel.from_xml_string(mjcf(true, p[:, laws.ADDED_INERTIA]))
    data: Any = mujoco.MjData(model)
    inertia = np.array([true[f"J_{i}"] for i in range(1, 7)]) + np.array([1.5, 3.0, 0.4, 0.002, 0.001, 0.0005])
    pull = 2 * math.pi * 4.0
    kp, kd, ki = inertia * pull**2, 1.4 * inertia * pull, 0.3 * inertia * pull**3
    data.qpos[:], data.qvel[:] = x[0], v[0]
    mujoco.mj_forward(model, data)
    total = 0.15 * data.qfrc_bias + np.sign(v[0]) * p[:, laws.LEVEL_P] + p[:, laws.VISCOUS] * v[0]
    z, load, applied = np.zeros((6, laws.STATES)), np.zeros(6), np.zeros(6)
    z[:, laws.LOAD_SPEED] = v[0]
    last, filtered, before = data.qpos.copy(), v[0].copy(), None
    angles, torques = np.empty_like(x), np.empty_like(x)
    guess, still = mujoco.MjData(model), np.zeros(6)
    h = CONTROL / STEPS
    for k in range(len(x)):
        seen = data.qpos + noise[k]
        filtered += 0.25 * ((seen - last) / CONTROL - filtered)
        last = seen
        guess.qpos[:], guess.qvel[:] = x[k], still
        mujoco.mj_fwdPosition(model, guess)
        mujoco.mj_fwdVelocity(model, guess)
        error = x[k] - seen
        total += ki * np.where(np.abs(error) < WIND_UP, error, 0.0) * CONTROL
        torque = kp * error + kd * (v[k] - filtered) + total + 0.85 * guess.qfrc_bias
        angles[k], torques[k] = seen, 0.5 * (torque + (torque if before is None else before))
        before = torque
        np.clip(torque, -limit, limit, out=applied)
        for j in range(STEPS):
            level, push = _laws(p, data.qpos, data.qvel, k * CONTROL + j * h, z, load, h)
            model.dof_frictionloss[:] = level
            data.qfrc_applied[:] = applied + push
            mujoco.mj_step(model, data)
            load = applied + data.qfrc_constraint + _drag(p, data.qvel)
    return angles, torques


@njit
def _drag(p, v):
    """What smooth friction takes off the load: that is what links, rotors and springs need."""
    force = np.empty(len(v))
    for i in range(len(v)):
        force[i] = laws.drag(p[i], v[i])
    return force


@njit
def _laws(p, q, v, t, z, load, h):
    """Levels of the dry friction (the same both ways) and all other forces, once the hidden states have come by ``h``.

    MuJoCo's speeds are those between two steps: ``v`` is that of the step which led to ``q``, and leads them, too.
    """
    n = len(q)
    level, push, after = np.empty(n), np.empty(n), np.empty(laws.STATES)
    for i in range(n):
        laws.advance_states(p[i], v[i], z[i], h, after)
        z[i] = after
        forwards, backwards = laws.dry_levels(p[i], q[i], v[i], load[i])
        level[i] = 0.5 * (forwards + backwards)
        push[i] = laws.smooth_force(p[i], q[i], v[i], t, z[i]) - 0.5 * (forwards - backwards)
    return level, push
