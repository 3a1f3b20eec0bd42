"""Tachometer: a voltage proportional to speed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import Effect, Port, Sensor, Values
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import Motion, PlaceKind


@final
class Tachometer(Effect):
    identifier = "tachometer"
    title = "tachometer"
    attaches_to = frozenset({PlaceKind.JOINT, PlaceKind.INERTIA})
    parameters = (
        ParameterSchema(
            "constant", {Motion.ROTATIONAL: "V s/rad", Motion.TRANSLATIONAL: "V s/m"}, "K_{Et}", "voltage per speed"
        ),
    )
    source = "van de Ven 1986, fig. 8"

    def sensor(self, port: Port, p: Values, z: Sequence[sp.Expr]) -> Sensor:
        return Sensor("voltage", "V", p["constant"] * port.v)
