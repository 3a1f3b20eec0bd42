"""Permanent-magnet d.c. motor: armature circuit and torque."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import Effect, HiddenState, Port, Rate, Values, same_unit
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import Motion, PlaceKind


@final
class DCMotor(Effect):
    """L dI/dt = U - R I - K_E omega; torque K_T I on the rotor.

    Where the inductance is left out, the current is no state: I = (U - K_E omega) / R at once.
    """

    identifier = "dc_motor"
    title = "permanent-magnet d.c. motor"
    attaches_to = frozenset({PlaceKind.INERTIA})
    parameters = (
        ParameterSchema("resistance", same_unit("Ohm"), "R", "armature resistance", None, lower=0.0),
        ParameterSchema(
            "inductance",
            same_unit("H"),
            "L",
            "armature inductance",
            None,
            lower=0.0,
            default=0.0,
            zero_is_structural=True,
        ),
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

    def hidden_states(self, p: Values) -> tuple[HiddenState, ...]:
        return () if p["inductance"] == 0 else (HiddenState("current", "A", "I"),)

    def rates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Rate, ...]:
        drop = self._driving_voltage(port, p, control)
        return tuple(Rate(p["inductance"], drop - p["resistance"] * current) for current in z)

    def current(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return z[0] if z else self._driving_voltage(port, p, control) / p["resistance"]

    def state_force(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return p["torque_constant"] * self.current(port, p, z, control)

    def stored_energy(self, p: Values, z: Sequence[sp.Expr]) -> sp.Expr:
        return sum((p["inductance"] * current**2 / 2 for current in z), sp.Integer(0))

    def supplied(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return control * self.current(port, p, z, control)

    def input_unit(self) -> str:
        return "V"

    def _driving_voltage(self, port: Port, p: Values, control: sp.Expr) -> sp.Expr:
        return control - p["back_emf_constant"] * port.v
