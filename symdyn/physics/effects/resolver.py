"""Resolver with its converter: the position, tracked with a lag."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import (
    DISPLACEMENT,
    MOVING,
    Effect,
    HiddenState,
    Port,
    Rate,
    Sensor,
    Values,
    same_unit,
)
from symdyn.spec.effect_schema import ParameterSchema


@final
class Resolver(Effect):
    """A lag of the first order, or none: what makes one channel late against the others."""

    identifier = "resolver"
    title = "resolver"
    attaches_to = MOVING
    parameters = (
        ParameterSchema("gain", same_unit("1"), "G_r", "shown per true displacement", default=1.0, nonzero=True),
        ParameterSchema("offset", DISPLACEMENT, "x_r", "shown at zero", default=0.0),
        ParameterSchema("time_constant", same_unit("s"), "T_r", "lag", lower=0.0, default=0.0, zero_is_structural=True),
    )
    source = "van de Ven 1986, fig. 8; Ellis 2012, Control System Design Guide, ch. 14"
    signature = "this channel is late against the others"

    def hidden_states(self, p: Values) -> tuple[HiddenState, ...]:
        return () if p["time_constant"] == 0 else (HiddenState("resolver", DISPLACEMENT, r"\theta"),)

    def rates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Rate, ...]:
        return tuple(Rate(p["time_constant"], _shown(port, p) - state) for state in z)

    def sensor(self, port: Port, p: Values, z: Sequence[sp.Expr]) -> Sensor:
        return Sensor("resolver", DISPLACEMENT, z[0] if z else _shown(port, p))


def _shown(port: Port, p: Values) -> sp.Expr:
    return p["gain"] * port.x + p["offset"]
