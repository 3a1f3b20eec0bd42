"""Torsion spring with a rest position: it pulls a joint, a rotor or a shaft towards one angle."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.physics.effect import DISPLACEMENT, MECHANICAL, STIFFNESS, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema


@final
class TorsionSpring(Effect):
    """The same law as a linear spring with a preload, in the numbers that a designer has."""

    identifier = "torsion_spring"
    title = "torsion spring"
    attaches_to = MECHANICAL
    parameters = (
        ParameterSchema("stiffness", STIFFNESS, "c", "force per displacement", lower=0.0),
        ParameterSchema("rest_position", DISPLACEMENT, "x_0", "displacement without force", null=None),
    )
    source = "Hooke 1678"
    signature = "residual proportional to position, with a mean"
    rivals = ("linear_spring", "counterbalance_spring")

    def potential_energy(self, port: Port, p: Values) -> sp.Expr:
        return p["stiffness"] * (port.x - p["rest_position"]) ** 2 / 2
