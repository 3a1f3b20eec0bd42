"""The plant of the drives: a chain of inertias on shafts, driven by a motor with its circuit and amplifier, by hand.

Midpoint rule at a fixed step; dry friction set-valued (``laws.hold``). A sampled servo on the motor's angle commands
the voltage. The last shaft may have a clearance, a cubic term, hysteresis, friction under load and a kinematic error.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from benchmarks.blind import laws
from benchmarks.blind.motions import CONTROL

SUPPLY = 24.0  # V
SHAFT = ("clearance", "cubic", "loop_level", "loop_yield", "loop_shape", "load_coefficient", "error_cosine",
         "error_sine", "error_order")  # fmt: skip
CLEARANCE, CUBIC, LOOP_LEVEL, LOOP_YIELD, LOOP_SHAPE, MU, ERROR_C, ERROR_S, ERROR_N = range(len(SHAFT))
AMPLIFIER = ("amplifier_offset", "amplifier_limit", "amplifier_dead_zone", "input_delay")
OFFSET, LIMIT, DEAD, DELAY = range(len(AMPLIFIER))


@njit  # without cache: Numba would not see that the laws it inlines have changed
def simulate(chain, springs, last, amplifier, motor, p, at, tacho, reference, speeds, dither, noise, stride, steps):
    """Voltage, current, motor angle, tachometer speed and load angle at the control samples, each (N).

    The servo acts at every ``stride``-th of them.
    """
    n, count = len(chain), len(reference)
    x, v = np.zeros(n) + reference[0], np.zeros(n) + speeds[0]
    z, z_mid = np.zeros((n, laws.STATES)), np.zeros((n, laws.STATES))
    dry, forwards, backwards = np.zeros(n), np.zeros(n), np.zeros(n)
    mobility = np.zeros((n, n))
    h = CONTROL / steps
    for i in range(n):
        mobility[i, i] = h / chain[i]
    late = round(amplifier[DELAY] / h)
    queue = np.zeros(late + 1)
    out = np.empty((5, count))
    current, loop, filtered, total, seen_last = 0.0, 0.0, speeds[0], 0.0, reference[0]
    load, u = 0.0, 0.0
    for k in range(count):
        seen = x[at] + noise[k]
        if k % stride == 0:  # the servo's own sample: the voltage is held from here to the next
            period = stride * CONTROL
            filtered += 0.3 * ((seen - seen_last) / period - filtered)
            seen_last = seen
            error = reference[k] - seen
            total += 6.0 * error * period
            u = 4.0 * error + total + 0.06 * (speeds[k] - filtered) + motor[3] * speeds[k] + dither[k]
            u = min(max(u, -SUPPLY), SUPPLY)
        out[0, k], out[1, k], out[2, k], out[3, k], out[4, k] = u, current, seen, v[tacho], x[n - 1]
        for j in range(steps):
            t = k * CONTROL + j * h
            slot = (k * steps + j) % (late + 1)
            queue[slot] = u
            volts = _amplified(amplifier, queue[(slot + 1) % (late + 1)])
            force, _ = _forces(springs, last, p, x, v, t, z, loop, motor[2] * current, at)
            rate = (volts - motor[0] * current - motor[3] * v[at]) / motor[1]
            x_mid, v_mid = x + 0.5 * h * v, v + 0.5 * h * (force + dry) / chain
            i_mid = current + 0.5 * h * rate
            for i in range(n):
                laws.advance_states(p[i], v_mid[i], z[i], 0.5 * h, z_mid[i])
            twist_rate = v[n - 1] - v[n - 2]
            loop_mid = loop + 0.5 * h * loop_rate(last, twist_rate, loop)
            force, load = _forces(springs, last, p, x_mid, v_mid, t + 0.5 * h, z_mid, loop_mid, motor[2] * i_mid, at)
            after = v + h * force / chain
            for i in range(n):
                forwards[i], backwards[i] = laws.dry_levels(p[i], x_mid[i], v_mid[i], load)
            forwards[n - 2] += last[MU] * abs(load)
            backwards[n - 2] += last[MU] * abs(load)
            laws.hold(after, mobility, forwards, backwards, dry)
            current += h * (volts - motor[0] * i_mid - motor[3] * v_mid[at]) / motor[1]
            loop += h * loop_rate(last, twist_rate, loop_mid)
            for i in range(n):
                laws.advance_states(p[i], 0.5 * (v[i] + after[i]), z[i], h, z_mid[i])
            z[:] = z_mid
            x += 0.5 * h * (v + after)
            v[:] = after
    return out[0], out[1], out[2], out[3], out[4]


@njit
def _forces(springs, last, p, x, v, t, z, loop, torque, at):
    """Forces on the inertias, dry friction left out, and the torque that the last shaft transmits."""
    n = len(x)
    force = np.empty(n)
    for i in range(n):
        force[i] = laws.smooth_force(p[i], x[i], v[i], t, z[i])
    force[at] += torque
    through = 0.0
    for i in range(n - 1):
        twist, rate = x[i + 1] - x[i], v[i + 1] - v[i]
        slope = 0.0
        if i == n - 2:
            through, slope = across(last, springs[i, 0], springs[i, 1], twist, rate, x[i], v[i], loop)
        else:
            through = springs[i, 0] * twist + springs[i, 1] * rate
        force[i] += through * (1.0 + slope)
        force[i + 1] -= through
    return force, through


@njit
def across(last, stiffness, damping, twist, rate, x, v, loop):
    """What the last shaft transmits, and the slope of its kinematic error; ``x`` and ``v`` are those of its start."""
    angle = last[ERROR_N] * x
    twist -= last[ERROR_C] * math.cos(angle) + last[ERROR_S] * math.sin(angle)
    slope = last[ERROR_N] * (last[ERROR_S] * math.cos(angle) - last[ERROR_C] * math.sin(angle))
    rate -= slope * v
    if abs(twist) <= last[CLEARANCE]:
        twist, rate = 0.0, 0.0
    else:
        twist -= math.copysign(last[CLEARANCE], twist)
    through = stiffness * twist + damping * rate
    if last[CLEARANCE] > 0.0 and through * twist < 0.0:  # a contact never pulls
        through = 0.0
    return through + (last[CUBIC] * twist**3 + last[LOOP_LEVEL] * loop), slope


@njit
def loop_rate(last, v, loop):
    if last[LOOP_LEVEL] == 0.0:
        return 0.0
    shape = last[LOOP_SHAPE]
    return (v - shape * abs(v) * abs(loop) * loop - (1.0 - shape) * v * loop * loop) / last[LOOP_YIELD]


@njit
def _amplified(amplifier, u):
    u += amplifier[OFFSET]
    u = min(max(u, -amplifier[LIMIT]), amplifier[LIMIT])
    return math.copysign(max(abs(u) - amplifier[DEAD], 0.0), u)
