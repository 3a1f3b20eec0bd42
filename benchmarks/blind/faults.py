"""What else may be concealed: faults of sensors and amplifiers, laws of shafts and circuits, terms left out."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from benchmarks.blind.effects import Draw
from benchmarks.blind.machine import Place
from benchmarks.blind.planting import Form, Planted
from benchmarks.blind.sensors import TACHO_CONSTANT


def _encoder(kind: str, place: Place, shown: str, value: float) -> Planted:
    form: Form = {"encoder": {shown: value}}
    return Planted(kind, place.address, fault=(f"{place.address}.position", {shown: value}), forms=(form,))


def encoder_offset(rng: np.random.Generator, place: Place) -> Planted:
    return _encoder("encoder_offset", place, "offset", rng.uniform(0.04, 0.12) * rng.choice((-1.0, 1.0)))


def encoder_gain(rng: np.random.Generator, place: Place) -> Planted:
    return _encoder("encoder_gain", place, "gain", float(rng.choice((0.9, 0.94, 1.06, 1.1))))


def encoder_steps(rng: np.random.Generator, place: Place) -> Planted:
    steps = float(rng.choice((400, 512, 1000)))  # per turn
    return _encoder("encoder_steps", place, "resolution", place.lead * 2.0 * math.pi / steps)


def late_efforts(rng: np.random.Generator, place: Place) -> Planted:
    """Every effort is shown late against the motion. A tool may name that, or refuse the recording for it."""
    late = rng.uniform(0.008, 0.02)
    form: Form = {"channel_skew": {"delay": late}}
    return Planted("late_efforts", "", fault=("effort", {"late": late}), forms=(form,), problems=("SD528", "SD529"))


def effort_limit(rng: np.random.Generator, place: Place) -> Planted:
    """The recorded effort is what the controller asked for; the drive gives no more than a limit."""
    limit = place.peak * rng.uniform(0.68, 0.78)
    return Planted(
        "effort_limit", place.address, plant={"effort_limit": limit}, forms=({"effort_saturation": {"limit": limit}},)
    )


def no_gravity(rng: np.random.Generator, place: Place) -> Planted:
    """The model handed over knows no gravity; where that is found does not matter."""
    forms: tuple[Form, ...] = ({"gravity": {}}, {"missing_gravity": {}}, {"neglected_gravity": {}})
    return Planted("no_gravity", "", forms=forms, omitted=frozenset({"gravity"}))


def _shaft(kind: str, place: Place, numbers: Mapping[str, float], *forms: Form) -> Planted:
    return Planted(kind, place.address, plant=numbers, forms=forms)


def backlash(rng: np.random.Generator, place: Place) -> Planted:
    clearance = place.reach * rng.uniform(0.3, 1.0)
    return _shaft("backlash", place, {"clearance": clearance}, {"backlash": {"clearance": clearance}})


def shaft_hardening(rng: np.random.Generator, place: Place) -> Planted:
    stiffness = place.force / place.reach**3 * rng.uniform(0.8, 2.0)
    return _shaft("shaft_hardening", place, {"cubic": stiffness}, {"hardening_spring": {"stiffness": stiffness}})


def shaft_hysteresis(rng: np.random.Generator, place: Place) -> Planted:
    level, length, shape = place.force * rng.uniform(0.6, 1.2), 0.2 * place.reach * rng.uniform(0.7, 1.5), 0.75
    values = {"level": level, "yield_displacement": length, "shape": shape}
    numbers = {"loop_level": level, "loop_yield": length, "loop_shape": shape}
    return _shaft("shaft_hysteresis", place, numbers, {"bouc_wen_hysteresis": values})


def shaft_friction(rng: np.random.Generator, place: Place) -> Planted:
    """Friction at the start of a shaft in proportion to the torque that it transmits."""
    coefficient = rng.uniform(0.1, 0.25)
    form: Form = {"load_dependent_friction": {"coefficient": coefficient}}
    return _shaft("shaft_friction", place, {"load_coefficient": coefficient}, form)


def kinematic_error(rng: np.random.Generator, place: Place) -> Planted:
    amplitude, phase = 0.6 * place.reach * rng.uniform(0.7, 1.5), rng.uniform(0.0, 2.0 * math.pi)
    order = float(rng.integers(3, 9))
    values = {"cosine": amplitude * math.cos(phase), "sine": amplitude * math.sin(phase), "order": order}
    numbers = {f"error_{name}": value for name, value in values.items()}
    return _shaft("kinematic_error", place, numbers, {"kinematic_error": values})


def compliance(rng: np.random.Generator, place: Place) -> Planted:
    """The shaft of a transmission that the model takes for rigid."""
    stiffness = place.force / place.reach * rng.uniform(0.7, 1.5)
    names = ("compliance", "shaft_compliance", "joint_compliance", "torsion_spring", "linear_spring")
    forms: tuple[Form, ...] = tuple({name: {"stiffness": stiffness}} for name in names)
    also = ("j1", "j1.motor", "j1.rotor", "j1.gear")
    return Planted("compliance", place.address, plant={"stiffness": stiffness}, forms=forms, also_at=also)


# An amplifier's gain, or an ammeter's, is no case: a motor whose own numbers are free takes it up without a trace.


def _amplifier(kind: str, place: Place, effect: str, parameter: str, value: float) -> Planted:
    return Planted(kind, place.address, plant={kind: value}, forms=({effect: {parameter: value}},))


def amplifier_offset(rng: np.random.Generator, place: Place) -> Planted:
    value = place.force * rng.uniform(0.5, 1.2) * rng.choice((-1.0, 1.0))
    return _amplifier("amplifier_offset", place, "amplifier_offset", "offset", value)


def amplifier_limit(rng: np.random.Generator, place: Place) -> Planted:
    value = place.force * rng.uniform(2.0, 2.8)
    return _amplifier("amplifier_limit", place, "amplifier_saturation", "limit", value)


def amplifier_dead_zone(rng: np.random.Generator, place: Place) -> Planted:
    value = place.force * rng.uniform(0.6, 1.4)
    return _amplifier("amplifier_dead_zone", place, "amplifier_dead_zone", "half_width", value)


def input_delay(rng: np.random.Generator, place: Place) -> Planted:
    return _amplifier("input_delay", place, "input_delay", "delay", 1e-3 * rng.integers(3, 8))


def ammeter_offset(rng: np.random.Generator, place: Place) -> Planted:
    value = rng.uniform(0.05, 0.15) * rng.choice((-1.0, 1.0))
    form: Form = {"ammeter": {"offset": value}}
    return Planted("ammeter_offset", place.address, fault=("current", {"offset": value}), forms=(form,))


def tacho_lag(rng: np.random.Generator, place: Place) -> Planted:
    lag = rng.uniform(0.004, 0.012)
    form: Form = {"tachometer": {"constant": TACHO_CONSTANT, "time_constant": lag}}
    fault = ("tacho", {"lag": lag})
    return Planted("tacho_lag", place.address, fault=fault, forms=(form,), scored={"time_constant": lag})


def _by_name(*draws: Draw) -> dict[str, Draw]:
    return {draw.__name__: draw for draw in draws}


ARM = _by_name(encoder_offset, encoder_gain, encoder_steps, effort_limit)
WHOLE = _by_name(no_gravity, late_efforts)
TACHO = _by_name(tacho_lag)
MISSING_SHAFT = _by_name(compliance)
SHAFT = _by_name(backlash, shaft_hardening, shaft_hysteresis, shaft_friction, kinematic_error)
CIRCUIT = _by_name(amplifier_offset, amplifier_limit, amplifier_dead_zone, input_delay, ammeter_offset)
