"""Coulomb friction: a force of constant size against the motion."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.base.nonsmooth import sign_of
from symdyn.physics.effect import EFFORT, MECHANICAL, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema


@final
class CoulombFriction(Effect):
    identifier = "coulomb_friction"
    title = "Coulomb friction"
    attaches_to = MECHANICAL
    parameters = (ParameterSchema("level", EFFORT, "F_c", "size of the friction force", lower=0.0),)
    source = "van de Ven 1986, fig. 5: T_f"
    signature = "residual jumps with the sign of speed"
    rivals = ("stribeck_friction",)
    dissipative = True
    proposable = True

    def force(self, port: Port, p: Values) -> sp.Expr:
        return -p["level"] * sign_of(port.v)
