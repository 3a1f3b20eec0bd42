"""A planar two-link arm, written by hand: a plant that shares no code with symdyn, for its recordings.

    python benchmarks/plants/two_link_plant.py --conceal ripple --joint elbow --seed 1 --out run.csv.gz
    python benchmarks/plants/two_link_plant.py --conceal ripple --follow trajectory.csv --out next.csv.gz

The arm moves in a vertical plane: q1 from the horizontal x axis, q2 relative to link 1, gravity along
-y (Spong, Hutchinson, Vidyasagar, "Robot Modeling and Control", section 7.3). Both joints have viscous
friction; one more effect, of a kind, place and size that a diagnosis is not told, acts at one joint.
Classical Runge-Kutta of order 4 at a fixed step; dry friction switches between sliding either way and
sticking, the change being located within a step; bristles (LuGre's friction) bend in half steps before and after the
arm moves, exactly at a constant speed. Angles in rad, torques in N m, times in s.
"""

from __future__ import annotations

import argparse
import gzip
import io
import math
import pathlib

import numpy as np

GRAVITY = 9.81
L1 = 0.5
M1, M2 = 1.08, 0.864
R1, R2 = 0.25, 0.2
I1, I2 = 0.022644, 0.0116352
VISCOUS = (0.30, 0.12)  # N m s/rad

JOINTS = ("shoulder", "elbow")
CONCEALED = {  # what each kind means, per joint: (shoulder, elbow)
    "none": ({}, {}),
    "coulomb": ({"level": 0.60}, {"level": 0.25}),
    "ripple": ({"amplitude": 0.80, "order": 11, "phase": 0.7}, {"amplitude": 0.35, "order": 11, "phase": 0.7}),
    "offset": ({"torque": 0.50}, {"torque": 0.20}),
    "stribeck": (
        {"level": 0.50, "static": 0.90, "speed": 0.15},
        {"level": 0.20, "static": 0.40, "speed": 0.15},
    ),
    "asymmetric_viscous": ({"forward": 0.30, "backward": 0.05}, {"forward": 0.15, "backward": 0.02}),
    "spring": ({"stiffness": 1.5, "rest": -0.8}, {"stiffness": 0.6, "rest": 0.3}),
    "lugre": (
        {"stiffness": 20.0, "level": 0.60, "excess": 0.30, "speed": 0.25},
        {"stiffness": 8.0, "level": 0.25, "excess": 0.12, "speed": 0.25},
    ),
}

STEP = 1e-4  # of the integration
SAMPLE_TIME = 1e-3  # of the controller and the recording
STEPS_PER_SAMPLE = round(SAMPLE_TIME / STEP)

ENCODER_QUANTUM = 2 * math.pi / 2**19
ENCODER_NOISE = 5e-6
TORQUE_QUANTUM = (2 * 20.0 / 2**12, 2 * 5.0 / 2**12)  # 12 bits over the range of each sensor
TORQUE_NOISE = 0.02

FUNDAMENTAL = 0.1  # Hz
HARMONICS = (1, 2, 3, 5, 7)
CENTRE = (-0.8, 0.3)
RANGE = (0.9, 1.2)

PROPORTIONAL = (260.0, 55.0)
INTEGRAL = (900.0, 250.0)
DERIVATIVE = (16.0, 2.6)
SPEED_FILTER = 0.25  # weight of the newest encoder difference
GRAVITY_GUESS = 0.85  # the controller's gravity model is that much of the truth


class Plant:
    """The arm with one concealed effect; a state is (q1, q2, v1, v2), and ``deflection`` that of its bristles."""

    def __init__(self, conceal="none", joint="elbow", viscous=VISCOUS):
        self.joint = JOINTS.index(joint)
        self.truth = dict(CONCEALED[conceal][self.joint])
        self.viscous = viscous
        self.smooth = _smooth_torque(conceal, self.truth)
        self.dry = _dry_level(conceal, self.truth)
        self.deflection = 0.0
        if conceal == "lugre":
            self.smooth = lambda q, v: -self.truth["stiffness"] * self.deflection

    def accelerations(self, state, torque, sliding=0):
        """(a1, a2) under the motor torques; ``sliding`` is +-1 or, for a joint that sticks, 0."""
        q1, q2, v1, v2 = state
        c2 = math.cos(q2)
        h = M2 * L1 * R2 * math.sin(q2)
        m11 = M1 * R1 * R1 + I1 + M2 * (L1 * L1 + R2 * R2 + 2 * L1 * R2 * c2) + I2
        m12 = M2 * (R2 * R2 + L1 * R2 * c2) + I2
        m22 = M2 * R2 * R2 + I2
        g2 = M2 * R2 * GRAVITY * math.cos(q1 + q2)
        g1 = (M1 * R1 + M2 * L1) * GRAVITY * math.cos(q1) + g2
        f1 = torque[0] + h * v2 * (2 * v1 + v2) - g1 - self.viscous[0] * v1
        f2 = torque[1] - h * v1 * v1 - g2 - self.viscous[1] * v2
        if self.joint == 0:
            if self.smooth is not None:
                f1 += self.smooth(q1, v1)
            elif self.dry is not None:
                if sliding == 0:
                    return 0.0, f2 / m22
                f1 -= sliding * self.dry(v1)
        elif self.smooth is not None:
            f2 += self.smooth(q2, v2)
        elif self.dry is not None:
            if sliding == 0:
                return f1 / m11, 0.0
            f2 -= sliding * self.dry(v2)
        determinant = m11 * m22 - m12 * m12
        return (m22 * f1 - m12 * f2) / determinant, (m11 * f2 - m12 * f1) / determinant

    def energy(self, state):
        """Kinetic and potential energy in J, the effects left out."""
        q1, q2, v1, v2 = state
        c2 = math.cos(q2)
        m11 = M1 * R1 * R1 + I1 + M2 * (L1 * L1 + R2 * R2 + 2 * L1 * R2 * c2) + I2
        m12 = M2 * (R2 * R2 + L1 * R2 * c2) + I2
        m22 = M2 * R2 * R2 + I2
        height = (M1 * R1 + M2 * L1) * math.sin(q1) + M2 * R2 * math.sin(q1 + q2)
        return 0.5 * (m11 * v1 * v1 + 2 * m12 * v1 * v2 + m22 * v2 * v2) + GRAVITY * height

    def advance(self, state, torque, duration):
        """The state after one step under constant torques; a joint that comes to rest in it is caught there."""
        speed = 2 + self.joint
        if self.dry is None:
            self._bend(state[speed], 0.5 * duration)
            after = self._runge_kutta(state, torque, 0, duration)
            self._bend(after[speed], 0.5 * duration)
            return after
        for _ in range(4):  # comes to rest, starts again, at most twice in a step
            sliding = self._sliding(state, torque)
            after = self._runge_kutta(state, torque, sliding, duration)
            if sliding * after[speed] >= 0.0:
                return after
            spent, after = self._until_rest(state, torque, sliding, duration, after)
            state = (*after[:speed], 0.0, *after[speed + 1 :])
            duration -= spent
        return state

    def _bend(self, v, duration):
        """dz/dt = v - s |v| z / g(v), g = level + excess exp(-(v/speed)^2) (Canudas de Wit et al. 1995, no damping)."""
        if "excess" not in self.truth or v == 0.0:
            return
        level = self.truth["level"] + self.truth["excess"] * math.exp(-((v / self.truth["speed"]) ** 2))
        steady = math.copysign(level / self.truth["stiffness"], v)
        self.deflection = steady + (self.deflection - steady) * math.exp(-abs(v) * duration / abs(steady))

    def _sliding(self, state, torque):
        """The direction in which the joint with dry friction slides, or 0 where friction can hold it."""
        speed = state[2 + self.joint]
        if speed != 0.0:
            return math.copysign(1.0, speed)
        # at rest, sliding starts where the full friction of rest is not enough; else it holds
        for direction in (1.0, -1.0):
            if direction * self.accelerations(state, torque, direction)[self.joint] > 0.0:
                return direction
        return 0

    def _until_rest(self, state, torque, sliding, duration, after):
        """Time until the sliding joint's speed is zero, and the state then (regula falsi, Illinois)."""
        speed = 2 + self.joint
        early, v_early, late, v_late = 0.0, state[speed], duration, after[speed]
        spent = duration
        for _ in range(50):
            spent = (early * v_late - late * v_early) / (v_late - v_early)
            after = self._runge_kutta(state, torque, sliding, spent)
            if abs(after[speed]) < 1e-13 or late - early < 1e-15:
                break
            if after[speed] * v_late > 0.0:
                late, v_late, v_early = spent, after[speed], 0.5 * v_early
            else:
                early, v_early, v_late = spent, after[speed], 0.5 * v_late
        return spent, after

    def _runge_kutta(self, state, torque, sliding, h):
        q1, q2, v1, v2 = state
        a1, a2 = self.accelerations(state, torque, sliding)
        k = 0.5 * h
        w1, w2 = v1 + k * a1, v2 + k * a2
        b1, b2 = self.accelerations((q1 + k * v1, q2 + k * v2, w1, w2), torque, sliding)
        x1, x2 = v1 + k * b1, v2 + k * b2
        c1, c2 = self.accelerations((q1 + k * w1, q2 + k * w2, x1, x2), torque, sliding)
        y1, y2 = v1 + h * c1, v2 + h * c2
        d1, d2 = self.accelerations((q1 + h * x1, q2 + h * x2, y1, y2), torque, sliding)
        k = h / 6.0
        return (
            q1 + k * (v1 + 2 * (w1 + x1) + y1),
            q2 + k * (v2 + 2 * (w2 + x2) + y2),
            v1 + k * (a1 + 2 * (b1 + c1) + d1),
            v2 + k * (a2 + 2 * (b2 + c2) + d2),
        )


def _smooth_torque(conceal, truth):
    """The concealed torque on its joint as a function of angle and speed; None for dry friction and none."""
    if conceal == "ripple":
        amplitude, order, phase = truth["amplitude"], truth["order"], truth["phase"]
        return lambda q, v: amplitude * math.sin(order * q + phase)
    if conceal == "offset":
        torque = truth["torque"]
        return lambda q, v: torque
    if conceal == "asymmetric_viscous":
        forward, backward = truth["forward"], truth["backward"]
        return lambda q, v: -(forward if v > 0.0 else backward) * v
    if conceal == "spring":
        stiffness, rest = truth["stiffness"], truth["rest"]
        return lambda q, v: -stiffness * (q - rest)
    return None


def _dry_level(conceal, truth):
    """The level of dry friction as a function of speed; at speed 0 it is the level that holds."""
    if conceal == "coulomb":
        level = truth["level"]
        return lambda v: level
    if conceal == "stribeck":
        level, rise, speed = truth["level"], truth["static"] - truth["level"], truth["speed"]
        return lambda v: level + rise * math.exp(-((v / speed) ** 2))
    return None


def reference(seed, duration):
    """Angles and speeds to follow, each (N, 2), at the sample times: sums of sines, period 10 s."""
    rng = np.random.default_rng([seed, 0])
    order = np.array(HARMONICS)
    time = SAMPLE_TIME * np.arange(round(duration / SAMPLE_TIME))
    period = np.arange(0.0, 1.0 / FUNDAMENTAL, SAMPLE_TIME)
    angles, speeds = np.empty((len(time), 2)), np.empty((len(time), 2))
    for joint in range(2):
        weight = rng.uniform(0.4, 1.0, len(order))
        phase = rng.uniform(0.0, 2 * math.pi, len(order))
        omega = 2 * math.pi * FUNDAMENTAL * order
        weight *= RANGE[joint] / np.max(np.abs(np.sin(np.outer(period, omega) + phase) @ weight))
        angles[:, joint] = CENTRE[joint] + np.sin(np.outer(time, omega) + phase) @ weight
        speeds[:, joint] = np.cos(np.outer(time, omega) + phase) @ (weight * omega)
    return angles, speeds


class Controller:
    """PID on encoder angles, with a filtered speed and a gravity model that is too light."""

    def __init__(self, angles, speeds):
        self.last = list(angles)
        self.speed = list(speeds)
        self.sum = [(1.0 - GRAVITY_GUESS) * g for g in _gravity(*angles)]  # settled before the recording starts

    def torque(self, measured, angles, speeds):
        guess = _gravity(*angles)
        torques = []
        for joint in range(2):
            newest = (measured[joint] - self.last[joint]) / SAMPLE_TIME
            self.speed[joint] += SPEED_FILTER * (newest - self.speed[joint])
            self.last[joint] = measured[joint]
            error = angles[joint] - measured[joint]
            self.sum[joint] += INTEGRAL[joint] * error * SAMPLE_TIME
            damping = DERIVATIVE[joint] * (speeds[joint] - self.speed[joint])
            torques.append(PROPORTIONAL[joint] * error + self.sum[joint] + damping + GRAVITY_GUESS * guess[joint])
        return tuple(torques)


def _gravity(q1, q2):
    g2 = M2 * R2 * GRAVITY * math.cos(q1 + q2)
    return (M1 * R1 + M2 * L1) * GRAVITY * math.cos(q1) + g2, g2


def trajectory(path):
    """Angles and speeds to follow, each (N, 2), from a CSV: time, two angles, two speeds, then what it likes."""
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    time = SAMPLE_TIME * np.arange(round(table[-1, 0] / SAMPLE_TIME) + 1)
    columns = np.column_stack([np.interp(time, table[:, 0], column) for column in table[:, 1:5].T])
    return columns[:, :2], columns[:, 2:]


def simulate(conceal, joint, seed, duration, noise=True, steps_per_sample=STEPS_PER_SAMPLE, follow=None):
    """What the sensors record while the arm follows the reference of the seed, or ``follow`` (angles, speeds).

    Returns t, q1, q2, tau1, tau2, each (N,). The torque sensor shows its mean over the sample time
    around each instant, so that torque and angle have no skew. Without ``noise`` the sensors are
    perfect: no noise, no quantisation.
    """
    plant = Plant(conceal, joint)
    angles, speeds = reference(seed, duration) if follow is None else follow
    count = len(angles)
    disturbance = np.random.default_rng([seed, 1]).standard_normal((count, 4)).tolist()
    path = list(zip(angles.tolist(), speeds.tolist(), strict=True))
    controller = Controller(*path[0])
    state = (*path[0][0], *path[0][1])
    step = SAMPLE_TIME / steps_per_sample
    rows = []
    before = None
    for (angle, speed), random in zip(path, disturbance, strict=True):
        measured = [_measure(state[i], ENCODER_NOISE * random[i], ENCODER_QUANTUM, noise) for i in range(2)]
        torque = controller.torque(measured, angle, speed)
        before = before or torque
        mean = [0.5 * (old + new) for old, new in zip(before, torque, strict=True)]
        shown = [_measure(mean[i], TORQUE_NOISE * random[2 + i], TORQUE_QUANTUM[i], noise) for i in range(2)]
        rows.append((*measured, *shown))
        for _ in range(steps_per_sample):
            state = plant.advance(state, torque, step)
        before = torque
    columns = np.array(rows).T
    return {"t": SAMPLE_TIME * np.arange(count), **dict(zip(("q1", "q2", "tau1", "tau2"), columns, strict=True))}


def _measure(value, noise, quantum, noisy):
    return quantum * round((value + noise) / quantum) if noisy else value


def csv_text(recording):
    """The recording as CSV: no digit that the sensors do not have."""
    rows = zip(*(recording[name].tolist() for name in ("t", "q1", "q2", "tau1", "tau2")), strict=True)
    return "t,q1,q2,tau1,tau2\n" + "".join("%.3f,%.6f,%.6f,%.4f,%.4f\n" % row for row in rows)  # noqa: UP031


def write_csv(path, recording):
    """Write the recording as .csv.gz; no date and no file name, so that equal recordings give equal bytes."""
    buffer = io.BytesIO()
    with gzip.GzipFile(filename="", fileobj=buffer, mode="wb", compresslevel=9, mtime=0) as stream:
        stream.write(csv_text(recording).encode("ascii"))
    pathlib.Path(path).write_bytes(buffer.getvalue())


def main():
    parser = argparse.ArgumentParser(description="Record a two-link arm with one concealed effect.")
    parser.add_argument("--conceal", choices=sorted(CONCEALED), default="none", help="the effect (default: none)")
    parser.add_argument("--joint", choices=JOINTS, default="elbow", help="where it acts (default: elbow)")
    parser.add_argument("--seed", type=int, default=1, help="of the motion and the noise (default: 1)")
    parser.add_argument("--duration", type=float, default=20.0, help="in s (default: 20)")
    parser.add_argument("--follow", help="a trajectory (CSV) instead of a random motion; its duration holds")
    parser.add_argument("--no-noise", action="store_true", help="perfect sensors")
    parser.add_argument("--out", required=True, help="file to write, .csv.gz")
    options = parser.parse_args()
    follow = trajectory(options.follow) if options.follow else None
    noise = not options.no_noise
    recording = simulate(options.conceal, options.joint, options.seed, options.duration, noise, follow=follow)
    write_csv(options.out, recording)


if __name__ == "__main__":
    main()
