"""Permanent-magnet d.c. motor: armature circuit and torque."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.physics.effect import Effect, HiddenState, Port, Values
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import Motion, PlaceKind


@final
class DCMotor(Effect):
    """L dI/dt = U - R I - K_E omega; torque K_T I on the rotor."""

    identifier = "dc_motor"
    title = "permanent-magnet d.c. motor"
    attaches_to = frozenset({PlaceKind.INERTIA})
    parameters = (
        ParameterSchema("resistance", dict.fromkeys(Motion, "Ohm"), "R", "armature resistance", None, lower=0.0),
        ParameterSchema("inductance", dict.fromkeys(Motion, "H"), "L", "armature inductance", None, lower=0.0),
        ParameterSchema(
            "torque_constant", {Motion.ROTATIONAL: "N m/A", Motion.TRANSLATIONAL: "N/A"}, "K_T", "torque per current"
        ),
        ParameterSchema(
            "back_emf_constant",
            {Motion.ROTATIONAL: "V s/rad", Motion.TRANSLATIONAL: "V s/m"},
            "K_E",
            "voltage per speed",
        ),
    )
    source = "van de Ven 1986, fig. 5 and the overall model"

    def hidden_state(self) -> HiddenState:
        return HiddenState("current", "A", "I")

    def storage_and_rate(self, port: Port, p: Values, state: sp.Expr, control: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
        return p["inductance"], control - p["resistance"] * state - p["back_emf_constant"] * port.v

    def state_force(self, port: Port, p: Values, state: sp.Expr) -> sp.Expr:
        return p["torque_constant"] * state

    def input_unit(self) -> str:
        return "V"
