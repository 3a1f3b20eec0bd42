"""Effects that no catalogue is expected to hold: the right answer is that something is left which has no name."""

from __future__ import annotations

import numpy as np

from benchmarks.blind.effects import Draw
from benchmarks.blind.machine import Place
from benchmarks.blind.planting import Planted


def magnetic_product(rng: np.random.Generator, place: Place) -> Planted:
    """Drag that comes and goes with the angle."""
    drag = 3.0 * place.force / place.speed * rng.uniform(0.8, 1.5)
    order = rng.uniform(3.0, 5.0) / place.reach
    return Planted("magnetic_product", place.address, {"product": drag, "product_order": order})


def eddy_current_peak(rng: np.random.Generator, place: Place) -> Planted:
    """Drag that rises with speed up to a peak and falls beyond it."""
    speed = place.speed * rng.uniform(0.2, 0.35)
    drag = 3.0 * place.force / speed * rng.uniform(0.8, 1.5)
    return Planted("eddy_current_peak", place.address, {"eddy": drag, "eddy_speed": speed})


def sticky_spot(rng: np.random.Generator, place: Place) -> Planted:
    """Dry friction in a narrow range of angles."""
    level, width = 2.5 * place.force * rng.uniform(0.8, 1.5), 0.15 * place.reach
    angle = place.centre + place.reach * rng.uniform(-0.4, 0.4)
    return Planted("sticky_spot", place.address, {"sticky_level": level, "sticky_angle": angle, "sticky_width": width})


def periodic_impact(rng: np.random.Generator, place: Place) -> Planted:
    """A kick of 30 ms, once per period that has nothing to do with the motion."""
    row = {
        "pulse": 5.0 * place.force * rng.uniform(0.8, 1.5),
        "pulse_period": rng.uniform(0.3, 0.6),
        "pulse_width": 0.03,
    }
    return Planted("periodic_impact", place.address, row)


def pumped_spring(rng: np.random.Generator, place: Place) -> Planted:
    """A spring whose stiffness changes with time."""
    stiffness = 3.0 * place.force / place.reach * rng.uniform(0.8, 1.5)
    row = {"pumped_stiffness": stiffness, "pumped_frequency": rng.uniform(0.5, 1.5), "pumped_rest": 0.0}
    return Planted("pumped_spring", place.address, row)


def choke(rng: np.random.Generator, place: Place) -> Planted:
    """A torque that is lost beyond a speed."""
    speed = place.speed * rng.uniform(0.4, 0.6)
    return Planted("choke", place.address, {"choke": 5.0 * place.force / place.speed, "choke_speed": speed})


def hum(rng: np.random.Generator, place: Place) -> Planted:
    """A torque that swings with time alone."""
    row = {"hum": 1.5 * place.force * rng.uniform(0.8, 1.5), "hum_frequency": rng.uniform(0.6, 2.5)}
    return Planted("hum", place.address, row)


UNKNOWN: dict[str, Draw] = {
    draw.__name__: draw
    for draw in (magnetic_product, eddy_current_peak, sticky_spot, periodic_impact, pumped_spring, choke, hum)
}
