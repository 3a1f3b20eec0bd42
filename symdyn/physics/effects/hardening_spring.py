"""Hardening spring: a force towards zero that grows with the cube of the displacement."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.physics.effect import MECHANICAL, Effect, Port, Values, mechanical
from symdyn.spec.effect_schema import ParameterSchema


@final
class HardeningSpring(Effect):
    """Beside a linear spring: the stiffness of a harmonic drive, which rises with torque."""

    identifier = "hardening_spring"
    title = "hardening spring"
    attaches_to = MECHANICAL
    parameters = (
        ParameterSchema(
            "stiffness", mechanical("N m/rad^3", "N/m^3"), "c_3", "force per cubed displacement", lower=0.0
        ),
    )
    source = "Duffing 1918"
    signature = "residual odd in position, curved"
    rivals = ("linear_spring",)
    proposable = True

    def potential_energy(self, port: Port, p: Values) -> sp.Expr:
        return p["stiffness"] * port.x**4 / 4
