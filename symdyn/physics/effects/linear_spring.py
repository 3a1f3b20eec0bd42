"""Linear spring: along a shaft its torsional stiffness, at a joint a spring towards a rest position."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.physics.effect import EFFORT, MECHANICAL, STIFFNESS, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema


@final
class LinearSpring(Effect):
    identifier = "linear_spring"
    title = "linear spring"
    attaches_to = MECHANICAL
    # Linear in both: the rest position is preload / stiffness.
    parameters = (
        ParameterSchema("stiffness", STIFFNESS, "c", "force per displacement", lower=0.0),
        ParameterSchema("preload", EFFORT, "F_p", "force along +x at zero displacement", default=0.0),
    )
    source = "van de Ven 1986, eq. 12"
    signature = "residual proportional to position"
    generalises = ("force_offset",)
    proposable = True

    def potential_energy(self, port: Port, p: Values) -> sp.Expr:
        return p["stiffness"] * port.x**2 / 2 - p["preload"] * port.x
