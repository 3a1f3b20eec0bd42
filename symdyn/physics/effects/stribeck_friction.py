"""Stribeck friction: an excess over Coulomb friction that decays with speed."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.base.nonsmooth import sign_of
from symdyn.physics.effect import EFFORT, MECHANICAL, SPEED, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema, Scan


@final
class StribeckFriction(Effect):
    identifier = "stribeck_friction"
    title = "Stribeck friction"
    attaches_to = MECHANICAL
    parameters = (
        ParameterSchema("excess", EFFORT, "F_s", "excess over Coulomb friction at zero speed", lower=0.0),
        ParameterSchema(
            "stribeck_velocity",
            SPEED,
            "v_s",
            "speed at which the excess has decayed to 1/e",
            null=None,
            lower=1e-12,
            scan=Scan.SPEED,
        ),
    )
    source = "Armstrong-Helouvry, Dupont, Canudas de Wit 1994, section 2 (Gaussian form)"
    signature = "residual grows towards zero speed, odd in speed"
    rivals = ("coulomb_friction", "asymmetric_viscous_friction")
    dissipative = True
    builds_on = "coulomb_friction"
    proposable = True

    def force(self, port: Port, p: Values) -> sp.Expr:
        return -p["excess"] * sp.exp(-((port.v / p["stribeck_velocity"]) ** 2)) * sign_of(port.v)
