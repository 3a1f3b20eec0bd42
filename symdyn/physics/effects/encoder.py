"""Encoder: the position in steps of its resolution."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.base.nonsmooth import quantise
from symdyn.physics.effect import DISPLACEMENT, MOVING, Effect, Port, Sensor, Values, same_unit
from symdyn.spec.effect_schema import ParameterSchema


@final
class Encoder(Effect):
    identifier = "encoder"
    title = "encoder"
    attaches_to = MOVING
    parameters = (
        ParameterSchema("gain", same_unit("1"), "G_e", "shown per true displacement", default=1.0, nonzero=True),
        ParameterSchema("offset", DISPLACEMENT, "x_e", "shown at zero", default=0.0),
        ParameterSchema(
            "resolution", DISPLACEMENT, "q_e", "size of a step", lower=0.0, default=0.0, zero_is_structural=True
        ),
    )
    source = "Ellis 2012, Control System Design Guide, ch. 14"
    signature = "position in steps; speed from it in bursts"

    def sensor(self, port: Port, p: Values, z: Sequence[sp.Expr]) -> Sensor:
        return Sensor("encoder", DISPLACEMENT, quantise(p["gain"] * port.x + p["offset"], p["resolution"]))
