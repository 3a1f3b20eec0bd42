"""Degressive friction: viscous at low speed, it rises ever less; of greased gears."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.physics.effect import DAMPING, MECHANICAL, SPEED, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema, Scan


@final
class DegressiveFriction(Effect):
    identifier = "degressive_friction"
    title = "degressive friction"
    attaches_to = MECHANICAL
    parameters = (
        ParameterSchema("coefficient", DAMPING, "F_g", "force per speed, at low speed", lower=0.0),
        ParameterSchema(
            "turnover_velocity",
            SPEED,
            "v_g",
            "speed at which it has risen to 76 % of all it comes to",
            null=None,
            lower=1e-12,
            scan=Scan.TURNOVER,
        ),
    )
    source = "Makkar, Dixon, Sawyer, Hu 2005: the tanh term; Gaz et al. 2019 have it in a Franka Panda"
    signature = "residual odd in speed, rising ever less"
    rivals = ("viscous_friction", "warm_up_friction")
    dissipative = True
    generalises = ("viscous_friction",)
    opens = False  # it resembles dry and viscous friction together, where a model has neither
    proposable = True

    def force(self, port: Port, p: Values) -> sp.Expr:
        return -p["coefficient"] * p["turnover_velocity"] * sp.tanh(port.v / p["turnover_velocity"])
