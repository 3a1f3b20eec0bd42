"""Quadratic drag: air, churning oil; a force against the motion, with the square of its speed."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.physics.effect import MECHANICAL, Effect, Port, Values, mechanical
from symdyn.spec.effect_schema import ParameterSchema


@final
class QuadraticDrag(Effect):
    identifier = "quadratic_drag"
    title = "quadratic drag"
    attaches_to = MECHANICAL
    parameters = (
        ParameterSchema(
            "coefficient", mechanical("N m s^2/rad^2", "N s^2/m^2"), "F_q", "force per squared speed", lower=0.0
        ),
    )
    source = "Rayleigh 1876: drag with the square of speed"
    signature = "residual odd in speed, curved"
    rivals = ("viscous_friction",)
    dissipative = True
    proposable = True

    def force(self, port: Port, p: Values) -> sp.Expr:
        return -p["coefficient"] * port.v * sp.Abs(port.v)
