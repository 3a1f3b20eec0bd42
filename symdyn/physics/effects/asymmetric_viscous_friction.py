"""Viscous friction that differs by direction: coefficient F_v + D forwards, F_v - D backwards."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.physics.effect import DAMPING, MECHANICAL, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema


@final
class AsymmetricViscousFriction(Effect):
    identifier = "asymmetric_viscous_friction"
    title = "direction-asymmetric viscous friction"
    attaches_to = MECHANICAL
    # With |D| <= F_v of the viscous friction beside it the sum is dissipative; alone it is not.
    parameters = (
        ParameterSchema("difference", DAMPING, r"\Delta F_v", "half the difference, forwards minus backwards"),
    )
    source = "Armstrong-Helouvry, Dupont, Canudas de Wit 1994, section 2"
    signature = "residual even in speed: it bends where the motion reverses"
    rivals = ("quadratic_drag", "stribeck_friction", "force_offset")
    builds_on = "viscous_friction"
    proposable = True

    def force(self, port: Port, p: Values) -> sp.Expr:
        return -p["difference"] * sp.Abs(port.v)
