"""Viscous friction: a force against the motion, proportional to its speed."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.physics.effect import DAMPING, MECHANICAL, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema


@final
class ViscousFriction(Effect):
    identifier = "viscous_friction"
    title = "viscous friction"
    attaches_to = MECHANICAL
    parameters = (ParameterSchema("coefficient", DAMPING, "F_v", "force per speed", lower=0.0),)
    source = "van de Ven 1986, eq. 13"
    signature = "residual proportional to speed"
    rivals = ("quadratic_drag", "asymmetric_viscous_friction")
    dissipative = True
    proposable = True

    def dissipation(self, port: Port, p: Values) -> sp.Expr:
        return p["coefficient"] * port.v**2 / 2
