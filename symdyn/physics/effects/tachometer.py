"""Tachometer: a voltage proportional to speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import MOVING, Effect, HiddenState, Port, Rate, Sensor, Values, mechanical, same_unit
from symdyn.spec.effect_schema import ParameterSchema


@final
class Tachometer(Effect):
    """Filtered by a lag of the first order, or not at all."""

    identifier = "tachometer"
    title = "tachometer"
    attaches_to = MOVING
    parameters = (
        ParameterSchema("constant", mechanical("V s/rad", "V s/m"), "K_{Et}", "voltage per speed", nonzero=True),
        ParameterSchema("time_constant", same_unit("s"), "T_t", "lag", lower=0.0, default=0.0, zero_is_structural=True),
    )
    source = "van de Ven 1986, fig. 8"

    def hidden_states(self, p: Values) -> tuple[HiddenState, ...]:
        return () if p["time_constant"] == 0 else (HiddenState("tachometer", "V", "U"),)

    def rates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Rate, ...]:
        return tuple(Rate(p["time_constant"], p["constant"] * port.v - state) for state in z)

    def sensor(self, port: Port, p: Values, z: Sequence[sp.Expr]) -> Sensor:
        return Sensor("voltage", "V", z[0] if z else p["constant"] * port.v)
