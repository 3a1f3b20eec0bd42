"""Warm-up friction: a lubricant that thins as its own friction heats it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import DAMPING, MECHANICAL, Effect, HiddenState, Port, Rate, Values, same_unit
from symdyn.spec.effect_schema import ParameterSchema, Scan


@final
class WarmUpFriction(Effect):
    """F_v exp(-T / T_0) v, where T is the temperature above that of the surroundings: C dT/dt = heat - T / R_T.

    Without a thermometer T_0 C and T_0 / R_T are all that shows; a diagnosis takes T_0 as known.
    """

    identifier = "warm_up_friction"
    title = "warm-up friction"
    attaches_to = MECHANICAL
    parameters = (
        ParameterSchema("coefficient", DAMPING, "F_w", "force per speed when cold", lower=0.0),
        ParameterSchema(
            "temperature_scale",
            same_unit("K"),
            "T_0",
            "rise that thins to 1/e",
            null=None,
            lower=1e-12,
            scan=Scan.ASSUMED,
            tried=(20.0,),
        ),
        ParameterSchema(
            "heat_capacity",
            same_unit("J/K"),
            "C_T",
            "heat per temperature",
            null=None,
            lower=1e-12,
            scan=Scan.HEAT,
            relative_to="coefficient",
            tried=(4.0, 10.0, 20.0, 40.0, 100.0),
        ),
        ParameterSchema(
            "thermal_resistance",
            same_unit("K/W"),
            "R_T",
            "temperature per heat flow outwards",
            null=None,
            lower=1e-12,
            scan=Scan.HEATING,
            relative_to="coefficient",
            inversely=True,
            tried=(10.0, 20.0, 40.0, 200.0),
        ),
    )
    source = "Bittencourt, Wernholt, Sander-Tavallaey, Brogardh 2010, An extended friction model"
    signature = "residual proportional to speed that fades over minutes of motion"
    rivals = ("viscous_friction",)
    generalises = ("viscous_friction",)
    opens = False  # it resembles dry and viscous friction together, where a model has neither
    dissipative = True
    proposable = True

    def hidden_states(self, p: Values) -> tuple[HiddenState, ...]:
        return (HiddenState("temperature_rise", "K", "T"),)

    def rates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Rate, ...]:
        heat = -self.state_force(port, p, z, control) * port.v
        return (Rate(p["heat_capacity"], heat - z[0] / p["thermal_resistance"]),)

    def state_force(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return -p["coefficient"] * sp.exp(-z[0] / p["temperature_scale"]) * port.v
