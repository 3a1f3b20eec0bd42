"""Forces on one moving coordinate, written by hand: what a plant may have that the model handed over lacks.

Nothing here is shared with symdyn. A coordinate has one row of numbers, zero where an effect is absent, and one row of
hidden states. Signs: a force is positive where it pushes the coordinate forwards.
"""

from __future__ import annotations

import math

from numba import njit

# The columns of a row of numbers.
NAMES = (
    "viscous",  # N m s/rad
    "viscous_difference",  # friction -d |v|: more one way than the other
    "quadratic",  # -q v |v|
    "level_positive",  # dry friction while moving forwards, N m
    "level_negative",  # and backwards
    "excess",  # Stribeck: dry friction at rest beyond the level
    "stribeck_speed",
    "load_coefficient",  # dry friction per load
    "offset",  # -offset
    "spring",  # -k (x - rest)
    "spring_rest",
    "cubic",  # -k x^3
    "balance_stiffness",  # a spring from a point on the part to one on the frame
    "balance_anchor",
    "balance_arm",
    "balance_free",
    "balance_centre",
    "ripple_cosine",
    "ripple_sine",
    "ripple_order",
    "unbalance_moment",  # mass * eccentricity * g
    "unbalance_phase",
    "added_inertia",
    "lugre_stiffness",
    "lugre_damping",
    "lugre_level",
    "lugre_excess",
    "lugre_speed",
    "dahl_stiffness",
    "dahl_level",
    "loop_level",  # Bouc-Wen, exponent 2
    "loop_yield",
    "loop_shape",
    "warm_coefficient",  # viscous friction that falls as the part warms up
    "warm_scale",
    "warm_capacity",
    "warm_resistance",
    "load_inertia",  # behind a spring and a damper
    "load_frequency",  # rad/s, of that while the coordinate is held
    "load_damping",  # a share of the critical one
    # Laws that no catalogue is expected to hold.
    "product",  # -a v (1 + cos(n x))/2: magnetic drag under some poles only
    "product_order",
    "eddy",  # -a v/(1 + (v/v0)^2): eddy currents, past their peak at speed
    "eddy_speed",
    "sticky_level",  # dry friction near one angle only
    "sticky_angle",
    "sticky_width",
    "pulse",  # a kick once per period of time
    "pulse_period",
    "pulse_width",
    "pumped_stiffness",  # -k sin(2 pi f t) (x - rest)
    "pumped_frequency",
    "pumped_rest",
    "choke",  # -k (|v| - v0) beyond the speed v0
    "choke_speed",
    "hum",  # a sin(2 pi f t)
    "hum_frequency",
)
COLUMN = {name: k for k, name in enumerate(NAMES)}
WIDTH = len(NAMES)
STATES = 6  # bristles of LuGre and of Dahl, Bouc-Wen's loop, temperature; twist before an elastic load, its speed
LOAD_SPEED = 5

(
    VISCOUS, VISCOUS_DIFFERENCE, QUADRATIC, LEVEL_P, LEVEL_N, EXCESS, STRIBECK_V, LOAD_MU, OFFSET, SPRING, SPRING_REST,
    CUBIC, BALANCE_K, BALANCE_ANCHOR, BALANCE_ARM, BALANCE_FREE, BALANCE_CENTRE, RIPPLE_C, RIPPLE_S, RIPPLE_N,
    UNBALANCE, UNBALANCE_PHASE, ADDED_INERTIA, LUGRE_K, LUGRE_D, LUGRE_LEVEL, LUGRE_EXCESS, LUGRE_V, DAHL_K, DAHL_LEVEL,
    LOOP_LEVEL, LOOP_YIELD, LOOP_SHAPE, WARM, WARM_SCALE, WARM_CAPACITY, WARM_RESISTANCE, LOAD_J, LOAD_W,
    LOAD_ZETA, PRODUCT, PRODUCT_N, EDDY, EDDY_V, STICKY, STICKY_X, STICKY_W, PULSE, PULSE_T, PULSE_W, PUMPED, PUMPED_F,
    PUMPED_REST, CHOKE, CHOKE_V, HUM, HUM_F,
) = range(WIDTH)  # fmt: skip


@njit(cache=True)
def drag(p, v):
    """The force of smooth friction."""
    return -p[VISCOUS] * v - p[VISCOUS_DIFFERENCE] * abs(v) - p[QUADRATIC] * v * abs(v)


@njit(cache=True)
def smooth_force(p, x, v, t, z):
    """The force of all effects of a coordinate but dry friction; ``z`` are its hidden states."""
    force = drag(p, v) - p[OFFSET]
    force -= p[SPRING] * (x - p[SPRING_REST]) + p[CUBIC] * x * x * x
    if p[BALANCE_K] != 0.0:
        turn = p[BALANCE_CENTRE] - x
        both = p[BALANCE_ANCHOR] * p[BALANCE_ARM]
        length = math.sqrt(p[BALANCE_ANCHOR] ** 2 + p[BALANCE_ARM] ** 2 - 2.0 * both * math.cos(turn))
        force += p[BALANCE_K] * (length - p[BALANCE_FREE]) * both * math.sin(turn) / length
    if p[RIPPLE_N] != 0.0:
        force += p[RIPPLE_C] * math.cos(p[RIPPLE_N] * x) + p[RIPPLE_S] * math.sin(p[RIPPLE_N] * x)
    if p[UNBALANCE] != 0.0:
        force += p[UNBALANCE] * math.sin(p[UNBALANCE_PHASE] - x)
    if p[LUGRE_K] != 0.0:
        level = lugre_level(p, v)
        rate = v - p[LUGRE_K] * abs(v) * z[0] / level
        force -= p[LUGRE_K] * z[0] + p[LUGRE_D] / (1.0 + p[LUGRE_D] * abs(v) / (4.0 * level)) * rate
    force -= p[DAHL_K] * z[1] + p[LOOP_LEVEL] * z[2]
    if p[WARM] != 0.0:
        force -= p[WARM] * math.exp(-z[3] / p[WARM_SCALE]) * v
    if p[LOAD_J] != 0.0:
        force -= p[LOAD_J] * _load_acceleration(p, v, z[4], z[5])
    return force + uncatalogued(p, x, v, t)


@njit(cache=True)
def uncatalogued(p, x, v, t):
    """The forces that no catalogue is expected to hold; the sticky spot is dry friction, see ``dry_levels``."""
    force = -0.5 * p[PRODUCT] * v * (1.0 + math.cos(p[PRODUCT_N] * x))
    if p[EDDY] != 0.0:
        force -= p[EDDY] * v / (1.0 + (v / p[EDDY_V]) ** 2)
    if p[PULSE] != 0.0:
        since = t % p[PULSE_T]
        if since < p[PULSE_W]:
            force += p[PULSE] * math.sin(math.pi * since / p[PULSE_W])
    force -= p[PUMPED] * math.sin(2.0 * math.pi * p[PUMPED_F] * t) * (x - p[PUMPED_REST])
    if p[CHOKE] != 0.0 and abs(v) > p[CHOKE_V]:
        force -= p[CHOKE] * math.copysign(abs(v) - p[CHOKE_V], v)
    return force + p[HUM] * math.sin(2.0 * math.pi * p[HUM_F] * t)


@njit(cache=True)
def dry_levels(p, x, v, load):
    """The most that dry friction can hold against motion forwards, and against motion backwards."""
    more = p[LOAD_MU] * abs(load)
    if p[EXCESS] != 0.0:
        more += p[EXCESS] * math.exp(-((v / p[STRIBECK_V]) ** 2))
    if p[STICKY] != 0.0:
        more += p[STICKY] * math.exp(-(((x - p[STICKY_X]) / p[STICKY_W]) ** 2))
    return p[LEVEL_P] + more, p[LEVEL_N] + more


@njit(cache=True)
def lugre_level(p, v):
    return p[LUGRE_LEVEL] + p[LUGRE_EXCESS] * math.exp(-((v / p[LUGRE_V]) ** 2))


@njit(cache=True)
def advance_states(p, v, z, h, out):
    """The hidden states a time ``h`` later, at a constant speed: exact for bristles and heat, midpoint for the rest."""
    out[:] = 0.0
    if p[LUGRE_K] != 0.0:
        out[0] = _bristle(z[0], v, p[LUGRE_K] / lugre_level(p, v), h)
    if p[DAHL_K] != 0.0:
        out[1] = _bristle(z[1], v, p[DAHL_K] / p[DAHL_LEVEL], h)
    if p[LOOP_LEVEL] != 0.0:
        middle = z[2] + 0.5 * h * _loop_rate(p, v, z[2])
        out[2] = z[2] + h * _loop_rate(p, v, middle)
    if p[WARM] != 0.0:
        heat = p[WARM] * math.exp(-z[3] / p[WARM_SCALE]) * v * v
        settled = heat * p[WARM_RESISTANCE]
        out[3] = settled + (z[3] - settled) * math.exp(-h / (p[WARM_RESISTANCE] * p[WARM_CAPACITY]))
    if p[LOAD_J] != 0.0:
        twist = z[4] + 0.5 * h * (v - z[5])
        speed = z[5] + 0.5 * h * _load_acceleration(p, v, z[4], z[5])
        out[4] = z[4] + h * (v - speed)
        out[5] = z[5] + h * _load_acceleration(p, v, twist, speed)


@njit(cache=True)
def _load_acceleration(p, v, twist, speed):
    return p[LOAD_W] * (p[LOAD_W] * twist + 2.0 * p[LOAD_ZETA] * (v - speed))


@njit(cache=True)
def _bristle(z, v, per_length, h):
    """dz/dt = v - per_length |v| z."""
    way = abs(v) * h
    if way * per_length < 1e-12:
        return z + v * h
    settled = math.copysign(1.0 / per_length, v)
    return settled + (z - settled) * math.exp(-per_length * way)


@njit(cache=True)
def _loop_rate(p, v, z):
    return (v - p[LOOP_SHAPE] * abs(v) * abs(z) * z - (1.0 - p[LOOP_SHAPE]) * v * z * z) / p[LOOP_YIELD]


@njit(cache=True)
def hold(speed, mobility, forwards, backwards, force):
    """Dry friction over one step, set-valued: ``speed`` (n) without it becomes the speed with it, in place.

    ``mobility`` (n, n) is the change of speed per force over the step; ``forwards`` and ``backwards`` (n) are what
    friction can hold; ``force`` (n), the friction, is changed in place and is the first guess. Projected Gauss-Seidel:
    a coordinate that friction can hold is at rest exactly (Moreau's time stepping).
    """
    n = len(speed)
    for i in range(n):
        force[i] = min(max(force[i], -forwards[i]), backwards[i])
    for i in range(n):
        for j in range(n):
            speed[i] += mobility[i, j] * force[j]
    for _ in range(200):
        change = 0.0
        for i in range(n):
            if forwards[i] == 0.0 and backwards[i] == 0.0 and force[i] == 0.0:
                continue
            new = min(max(force[i] - speed[i] / mobility[i, i], -forwards[i]), backwards[i])
            step = new - force[i]
            force[i] = new
            for j in range(n):
                speed[j] += mobility[j, i] * step
            change = max(change, abs(step) / (1e-300 + forwards[i] + backwards[i]))
        if change < 1e-10:
            return
