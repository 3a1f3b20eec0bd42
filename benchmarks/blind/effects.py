"""Effects that a catalogue holds, ready to be planted at a moving coordinate: sizes drawn, right answers written down.

Names of effects and parameters in the forms are those of `symdyn effects`; docs/blind.md says what each means. A size
is drawn about a tenth of the torque that is usual at the place, whatever the machine.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from benchmarks.blind.machine import Place
from benchmarks.blind.planting import Form, Planted

Draw = Callable[[np.random.Generator, Place], Planted]
GRAVITY = 9.81


def _planted(
    kind: str,
    place: Place,
    row: Mapping[str, float],
    *forms: Form,
    replaces: str = "",
    scored: Mapping[str, float] | None = None,
) -> Planted:
    omitted = frozenset({f"{replaces} {place.address}"} if replaces else ())
    return Planted(kind, place.address, row, forms=forms, omitted=omitted, replaces=replaces, scored=scored)


def coulomb(rng: np.random.Generator, place: Place) -> Planted:
    level = place.force * rng.uniform(0.6, 1.6)
    row = {"level_positive": level, "level_negative": level}
    return _planted("coulomb", place, row, {"coulomb_friction": {"level": level}}, replaces="dry")


def asymmetric_coulomb(rng: np.random.Generator, place: Place) -> Planted:
    forwards = place.force * rng.uniform(0.8, 1.6)
    backwards = forwards * rng.uniform(0.3, 0.7)
    if rng.random() < 0.5:
        forwards, backwards = backwards, forwards
    row = {"level_positive": forwards, "level_negative": backwards}
    whole = {"asymmetric_coulomb_friction": row}
    mean, half = 0.5 * (forwards + backwards), 0.5 * (forwards - backwards)
    parts = {"coulomb_friction": {"level": mean}, "force_offset": {"offset": half}}
    return _planted("asymmetric_coulomb", place, row, whole, parts, replaces="dry")


def stribeck(rng: np.random.Generator, place: Place) -> Planted:
    level, excess = place.force * rng.uniform(0.6, 1.2), place.force * rng.uniform(0.6, 1.2)
    speed = place.speed * rng.uniform(0.07, 0.2)
    row = {"level_positive": level, "level_negative": level, "excess": excess, "stribeck_speed": speed}
    form = {
        "coulomb_friction": {"level": level},
        "stribeck_friction": {"excess": excess, "stribeck_velocity": speed},
    }
    return _planted("stribeck", place, row, form, replaces="dry")


def lugre(rng: np.random.Generator, place: Place) -> Planted:
    level, excess = place.force * rng.uniform(0.8, 1.6), place.force * rng.uniform(0.2, 0.6)
    stiffness = (level + excess) / (place.reach * rng.uniform(0.02, 0.05))
    damping, speed = 0.1 * place.force / place.speed, place.speed * rng.uniform(0.07, 0.2)
    row = {
        "lugre_stiffness": stiffness, "lugre_damping": damping, "lugre_level": level, "lugre_excess": excess,
        "lugre_speed": speed,
    }  # fmt: skip
    values = {
        "stiffness": stiffness, "damping": damping, "level": level, "excess": excess, "stribeck_velocity": speed,
    }  # fmt: skip
    return _planted("lugre", place, row, {"lugre_friction": values}, replaces="dry")


def dahl(rng: np.random.Generator, place: Place) -> Planted:
    level = place.force * rng.uniform(0.8, 1.6)
    stiffness = level / (place.reach * rng.uniform(0.03, 0.08))
    row = {"dahl_stiffness": stiffness, "dahl_level": level}
    return _planted("dahl", place, row, {"dahl_friction": {"stiffness": stiffness, "level": level}}, replaces="dry")


def bouc_wen(rng: np.random.Generator, place: Place) -> Planted:
    level, length, shape = place.force * rng.uniform(0.8, 1.6), place.reach * rng.uniform(0.05, 0.12), 0.75
    row = {"loop_level": level, "loop_yield": length, "loop_shape": shape}
    values = {"level": level, "yield_displacement": length, "shape": shape}
    return _planted("bouc_wen", place, row, {"bouc_wen_hysteresis": values}, replaces="dry")


def viscous(rng: np.random.Generator, place: Place) -> Planted:
    coefficient = 2.0 * place.force / place.speed * rng.uniform(0.5, 1.5)
    form = {"viscous_friction": {"coefficient": coefficient}}
    return _planted("viscous", place, {"viscous": coefficient}, form, replaces="viscous")


def asymmetric_viscous(rng: np.random.Generator, place: Place) -> Planted:
    difference = place.force / place.speed * rng.uniform(0.6, 1.2) * rng.choice((-1.0, 1.0))
    form = {"asymmetric_viscous_friction": {"difference": difference}}
    return _planted("asymmetric_viscous", place, {"viscous_difference": difference}, form)


def warm_up(rng: np.random.Generator, place: Place) -> Planted:
    coefficient = 2.0 * place.force / place.speed * rng.uniform(0.8, 1.5)
    capacity = 0.25 * coefficient * place.speed**2 * 8.0 / 20.0  # 20 K in about 8 s
    row = {
        "warm_coefficient": coefficient, "warm_scale": 25.0, "warm_capacity": capacity,
        "warm_resistance": 30.0 / capacity,
    }  # fmt: skip
    values = {
        "coefficient": coefficient, "temperature_scale": 25.0, "heat_capacity": capacity,
        "thermal_resistance": 30.0 / capacity,
    }  # fmt: skip
    scored = {"coefficient": coefficient}
    return _planted("warm_up", place, row, {"warm_up_friction": values}, replaces="viscous", scored=scored)


def quadratic_drag(rng: np.random.Generator, place: Place) -> Planted:
    coefficient = place.force / place.speed**2 * rng.uniform(0.6, 1.6)
    return _planted(
        "quadratic_drag", place, {"quadratic": coefficient}, {"quadratic_drag": {"coefficient": coefficient}}
    )


def load_dependent(rng: np.random.Generator, place: Place) -> Planted:
    coefficient = rng.uniform(0.08, 0.2)
    form = {"load_dependent_friction": {"coefficient": coefficient}}
    return _planted("load_dependent", place, {"load_coefficient": coefficient}, form)


def ripple(rng: np.random.Generator, place: Place) -> Planted:
    amplitude, phase = place.force * rng.uniform(0.6, 1.4), rng.uniform(0.0, 2.0 * math.pi)
    order = float(rng.integers(6, 25)) * max(1.0, 1.0 / place.reach)
    values = {"cosine": amplitude * math.cos(phase), "sine": amplitude * math.sin(phase), "order": round(order)}
    row = {f"ripple_{name}": value for name, value in values.items()}
    return _planted("ripple", place, row, {"torque_ripple": values})


def offset(rng: np.random.Generator, place: Place) -> Planted:
    value = place.force * rng.uniform(0.5, 1.2) * rng.choice((-1.0, 1.0))
    return _planted("offset", place, {"offset": value}, {"force_offset": {"offset": value}})


def spring(rng: np.random.Generator, place: Place) -> Planted:
    stiffness = 1.5 * place.force / place.reach * rng.uniform(0.6, 1.4)
    rest = place.reach * rng.uniform(-0.8, 0.8)
    torsion = {"torsion_spring": {"stiffness": stiffness, "rest_position": rest}}
    linear = {"linear_spring": {"stiffness": stiffness, "preload": stiffness * rest}}
    return _planted("spring", place, {"spring": stiffness, "spring_rest": rest}, torsion, linear)


def hardening(rng: np.random.Generator, place: Place) -> Planted:
    stiffness = 1.5 * place.force / place.reach**3 * rng.uniform(0.6, 1.4)
    return _planted("hardening", place, {"cubic": stiffness}, {"hardening_spring": {"stiffness": stiffness}})


def counterbalance(rng: np.random.Generator, place: Place) -> Planted:
    anchor, arm, free = 0.30, 0.15, 0.12
    stiffness = 3.0 * place.force / (anchor * arm) * rng.uniform(0.7, 1.4)
    values = {
        "stiffness": stiffness, "anchor": anchor, "arm": arm, "free_length": free,
        "dead_centre": float(rng.uniform(1.0, 2.0)),
    }  # fmt: skip
    short = {"free_length": "free", "dead_centre": "centre"}
    row = {f"balance_{short.get(name, name)}": value for name, value in values.items()}
    scored = {"stiffness*anchor*arm": stiffness * anchor * arm, "dead_centre": values["dead_centre"]}
    return _planted("counterbalance", place, row, {"counterbalance_spring": values}, scored=scored)


def unbalance(rng: np.random.Generator, place: Place) -> Planted:
    """A weight beside the line on which the model has its centre of mass; only mass times eccentricity can be told."""
    moment, phase, eccentricity = 1.5 * place.force * rng.uniform(0.7, 1.4), float(rng.choice((0.0, math.pi))), 0.1
    mass = moment / (GRAVITY * eccentricity)
    row = {"unbalance_moment": moment, "unbalance_phase": phase, "added_inertia": mass * eccentricity**2}
    values = {"mass": mass, "eccentricity": eccentricity, "phase": phase}
    scored = {"mass*eccentricity": moment / GRAVITY, "phase": phase}
    return _planted("unbalance", place, row, {"unbalance": values}, scored=scored)


def added_inertia(rng: np.random.Generator, place: Place) -> Planted:
    inertia = place.force / (5.0 * place.speed) * rng.uniform(0.7, 1.5)
    return _planted("added_inertia", place, {"added_inertia": inertia}, {"added_inertia": {"inertia": inertia}})


def elastic_load(rng: np.random.Generator, place: Place) -> Planted:
    """An inertia behind a spring and a damper: it swings where the motion is quick enough."""
    inertia = place.force * place.reach / place.speed**2 * rng.uniform(0.7, 1.5)
    frequency, damping = 2.0 * math.pi * rng.uniform(1.2, 3.0), rng.uniform(0.02, 0.1)
    row = {"load_inertia": inertia, "load_frequency": frequency, "load_damping": damping}
    values = {"inertia": inertia, "frequency": frequency, "damping_ratio": damping}
    return _planted("elastic_load", place, row, {"elastic_load": values})


MOVING: dict[str, Draw] = {
    draw.__name__: draw
    for draw in (
        coulomb, asymmetric_coulomb, stribeck, lugre, dahl, bouc_wen, viscous, asymmetric_viscous, warm_up,
        quadratic_drag, load_dependent, ripple, offset, spring, hardening, counterbalance, unbalance, added_inertia,
    )
}  # fmt: skip
ELASTIC: dict[str, Draw] = {"elastic_load": elastic_load}
