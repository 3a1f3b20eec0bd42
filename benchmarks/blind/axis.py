"""The linear axis: a carriage on a rack, horizontal, by a hand-written equation, and the model that is handed over.

Midpoint rule at a fixed step; dry friction set-valued (``laws.hold``); a sampled PID controller on the encoder of the
pinion. The effort recorded is the one that the controller asked for.
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

STEPS = 40  # of the integration per control sample
DURATION = 10.0  # s
RACK = 0.05  # m/rad, of the pinion that carries the encoder
FORCE = 240.0  # N: full range
TRUE = {"m": (60.0, "kg"), "b": (25.0, "N s/m"), "F_c": (9.0, "N")}
REACH, ACCELERATION = 0.35, 2.4  # m, m/s^2: about as far, and as quick
PLACES = (Place("j1", "joint", 12.0, 0.5, REACH, 170.0, 0.0, lead=RACK),)

MODEL = """[robot]
name = "machine"
gravity = [0, 0, 0]

[parameters]
{parameters}

[dh]
rows = [ [ 0, "q", 0, 0 ] ]

[[joint]]
name = "j1"
link = {{ mass = "m" }}
{effects}
{channels}"""
OWN = (("viscous j1", "b", "viscous_friction", "coefficient"), ("dry j1", "F_c", "coulomb_friction", "level"))


class Axis(Machine):
    name = "axis"
    places = PLACES
    truth = TRUE

    def record(
        self, planted: tuple[Planted, ...], true: Mapping[str, float], run: int, level: str, seed: int
    ) -> Recorded:
        rng = self.rng(planted, run, level, seed)
        centre = rng.uniform(-0.1, 0.1)
        x, v = multisine(rng, run, DURATION, np.zeros(1), np.array([REACH]))
        scale = ACCELERATION * CONTROL / np.max(np.abs(np.diff(v, axis=0)))
        x, v = centre + scale * x, scale * v
        own = {"viscous": true["b"], "level_positive": true["F_c"], "level_negative": true["F_c"]}
        p = rows(planted, self.places, [own])
        limit = self.plant_of(planted, "j1").get("effort_limit", math.inf)
        sensors = LEVELS[level]
        noise = RACK * sensors.encoder_noise * rng.standard_normal(len(x))
        seen, force = simulate(true["m"], p, limit, x[:, 0], v[:, 0], noise, STEPS)
        every = slice(None, None, sensors.stride)
        angle = faulty(seen, self.fault_of(planted, "j1.position"))[every] / RACK
        effort = faulty(force, self.fault_of(planted, "effort"))[every]
        columns = {"x1": RACK * encoder(angle, sensors), "y1": analogue(effort, FORCE, sensors, rng)}
        return Recorded.even(CONTROL * sensors.stride, columns)

    def model(self, given: Mapping[str, float], planted: tuple[Planted, ...], seed: int, form: bool = False) -> str:
        gone = {part for plant in planted for part in plant.omitted}
        kept = [law for law in OWN if law[0] not in gone]
        effects = "".join(effect_table(effect, "j1", {name: f'"{p}"'}) for _, p, effect, name in kept)
        return MODEL.format(
            parameters=parameter_lines(self.truth, given, {p for _, p, _, _ in OWN} - {p for _, p, _, _ in kept}),
            effects=effects + self.form_text(planted, form),
            channels=joint_channels(("j1",), "effort", "N", "m"),
        )


@njit  # without cache: Numba would not see that the laws it inlines have changed
def simulate(mass, p, limit, reference, speeds, noise, steps):
    """Positions as the encoder shows them and mean forces around the control samples, each (N)."""
    count = len(reference)
    x, v = reference[0], speeds[0]
    z, z_mid = np.zeros(laws.STATES), np.zeros(laws.STATES)
    z[laws.LOAD_SPEED] = v
    dry, forwards, backwards, after = np.zeros(1), np.zeros(1), np.zeros(1), np.zeros(1)
    mobility = np.zeros((1, 1))
    total, last, filtered, before = 0.0, x, v, 0.0
    positions, forces = np.zeros(count), np.zeros(count)
    inertia = mass + p[0, laws.ADDED_INERTIA]
    h = CONTROL / steps
    mobility[0, 0] = h / inertia
    for k in range(count):
        seen = x + noise[k]
        filtered += 0.25 * ((seen - last) / CONTROL - filtered)
        last = seen
        error = reference[k] - seen
        if abs(error) < RACK * WIND_UP:
            total += 2e4 * error * CONTROL
        force = 6e3 * error + total + 1.2e3 * (speeds[k] - filtered)
        positions[k] = seen
        forces[k] = 0.5 * (force + (before if k > 0 else force))
        before = force
        applied = min(max(force, -limit), limit)
        for j in range(steps):
            t = k * CONTROL + j * h
            smooth = applied + laws.smooth_force(p[0], x, v, t, z)
            x_mid, v_mid = x + 0.5 * h * v, v + 0.5 * h * (smooth + dry[0]) / inertia
            laws.advance_states(p[0], v_mid, z, 0.5 * h, z_mid)
            # the load is what carriage and springs need: no friction; of the step before
            load = applied + dry[0] + laws.drag(p[0], v_mid)
            forwards[0], backwards[0] = laws.dry_levels(p[0], x_mid, v_mid, load)
            after[0] = v + h * (applied + laws.smooth_force(p[0], x_mid, v_mid, t + 0.5 * h, z_mid)) / inertia
            laws.hold(after, mobility, forwards, backwards, dry)
            laws.advance_states(p[0], 0.5 * (v + after[0]), z, h, z_mid)
            z[:] = z_mid
            x += 0.5 * h * (v + after[0])
            v = after[0]
    return positions, forces
