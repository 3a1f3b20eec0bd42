"""Dahl friction: Coulomb friction that is reached over a distance, through a spring that yields."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import (
    DISPLACEMENT,
    EFFORT,
    MECHANICAL,
    STIFFNESS,
    Effect,
    HiddenState,
    Port,
    Rate,
    Values,
)
from symdyn.spec.effect_schema import ParameterSchema, Scan


@final
class DahlFriction(Effect):
    """dz/dt = v - s |v| z / F_c, force -s z: hysteresis that does not depend on the rate."""

    identifier = "dahl_friction"
    title = "Dahl friction"
    attaches_to = MECHANICAL
    parameters = (
        ParameterSchema(
            "stiffness",
            STIFFNESS,
            r"\sigma",
            "stiffness at a reversal",
            lower=0.0,
            scan=Scan.STEEPNESS,
            relative_to="level",
        ),
        ParameterSchema("level", EFFORT, "F_c", "friction force far from the last reversal", null=None, lower=1e-12),
    )
    source = "Dahl 1968, A solid friction model (exponent 1)"
    signature = "residual depends on the distance since the last reversal"
    rivals = ("coulomb_friction", "lugre_friction", "bouc_wen_hysteresis")
    generalises = ("coulomb_friction",)
    dissipative = True
    proposable = True

    def hidden_states(self, p: Values) -> tuple[HiddenState, ...]:
        return (HiddenState("elastic_deflection", DISPLACEMENT, "z"),)

    def rates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Rate, ...]:
        return (Rate(sp.Integer(1), port.v - p["stiffness"] * sp.Abs(port.v) * z[0] / p["level"]),)

    def state_force(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return -p["stiffness"] * z[0]

    def stored_energy(self, p: Values, z: Sequence[sp.Expr]) -> sp.Expr:
        return p["stiffness"] * z[0] ** 2 / 2
