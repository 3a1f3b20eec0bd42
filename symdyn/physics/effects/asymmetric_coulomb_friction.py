"""Coulomb friction whose level differs by direction; none at rest."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.base.nonsmooth import step
from symdyn.physics.effect import EFFORT, MECHANICAL, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema


@final
class AsymmetricCoulombFriction(Effect):
    """In a recording it is Coulomb friction with a constant offset; those two are what a diagnosis proposes."""

    identifier = "asymmetric_coulomb_friction"
    title = "direction-asymmetric Coulomb friction"
    attaches_to = MECHANICAL
    parameters = (
        ParameterSchema(
            "level_positive", EFFORT, "F_c^+", "size of the friction force where the speed is positive", lower=0.0
        ),
        ParameterSchema(
            "level_negative", EFFORT, "F_c^-", "size of the friction force where the speed is negative", lower=0.0
        ),
    )
    source = "Armstrong-Helouvry, Dupont, Canudas de Wit 1994, section 2"
    signature = "residual jumps with the sign of speed, by different amounts to either side of zero"
    rivals = ("coulomb_friction", "force_offset")
    dissipative = True

    def force(self, port: Port, p: Values) -> sp.Expr:
        return p["level_negative"] * step(-port.v) - p["level_positive"] * step(port.v)
