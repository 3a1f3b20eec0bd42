"""Kinematic error of a gear: the output leads or lags by a wave of the input angle."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import sympy as sp

from symdyn.physics.effect import TURNING, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema, Scan
from symdyn.spec.records import Motion, PlaceKind


@final
class KinematicError(Effect):
    """At a shaft, whose start is the side that the wave is counted on (the wave generator).

    The shaft is at rest where end = start + e(start). What it transmits feels the twist less e, and its
    speed less de/dt; so the start feels the torque times 1 + e', and no energy is made or lost.
    """

    identifier = "kinematic_error"
    title = "kinematic error"
    attaches_to = frozenset({PlaceKind.SHAFT})
    motions = TURNING
    parameters = (
        ParameterSchema(
            "cosine", {Motion.ROTATIONAL: "rad"}, "e_c", "amplitude of the cosine of the angle times the order"
        ),
        ParameterSchema(
            "sine", {Motion.ROTATIONAL: "rad"}, "e_s", "amplitude of the sine of the angle times the order"
        ),
        ParameterSchema(
            "order",
            {Motion.ROTATIONAL: "rad/rad"},
            "n",
            "waves per turn of the start",
            null=None,
            lower=1e-12,
            scan=Scan.ANGLE_ORDER,
        ),
    )
    proposable = True
    source = "Tuttle and Seering 1996, A nonlinear model of a harmonic drive gear transmission"
    signature = "vibration at a multiple of the motor's speed, largest where that meets a resonance"
    rivals = ("torque_ripple",)

    def transmission(self, port: Port, p: Values) -> Port:
        assert port.start is not None
        angle = p["order"] * port.start.x
        error = p["cosine"] * sp.cos(angle) + p["sine"] * sp.sin(angle)
        slope = p["order"] * (p["sine"] * sp.cos(angle) - p["cosine"] * sp.sin(angle))
        return replace(port, x=port.x - error, v=port.v - slope * port.start.v)
