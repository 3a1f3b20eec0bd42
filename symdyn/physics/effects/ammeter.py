"""Ammeter: the current in a motor's circuit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import CIRCUIT, ELECTRICAL, Effect, Port, Sensor, Values
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import Motion


@final
class Ammeter(Effect):
    identifier = "ammeter"
    title = "ammeter"
    attaches_to = CIRCUIT
    motions = ELECTRICAL
    parameters = (
        ParameterSchema("gain", {Motion.ELECTRICAL: "1"}, "G_a", "shown per true current", default=1.0, nonzero=True),
        ParameterSchema("offset", {Motion.ELECTRICAL: "A"}, "I_0", "shown without current", default=0.0),
    )
    proposable = True
    source = "van de Ven 1986, fig. 5"
    signature = "current off by a factor or a constant"

    def sensor(self, port: Port, p: Values, z: Sequence[sp.Expr]) -> Sensor:
        return Sensor("ammeter", "A", p["gain"] * port.v + p["offset"])
