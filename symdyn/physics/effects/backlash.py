"""Backlash: the impact pair; a clearance within which a shaft transmits nothing."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import sympy as sp

from symdyn.base.nonsmooth import deadzone, outside
from symdyn.physics.effect import DISPLACEMENT, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import PlaceKind


@final
class Backlash(Effect):
    """Within +-S of twist the shaft is free; in contact its spring and its damper both act, but never pull.

    The paper prints the condition on ``x2 - x1``; it must be on ``|x2 - x1|``.
    """

    identifier = "backlash"
    title = "backlash"
    attaches_to = frozenset({PlaceKind.SHAFT})
    parameters = (ParameterSchema("clearance", DISPLACEMENT, "S", "half the free play", lower=0.0),)
    proposable = True
    source = "van de Ven 1986, eq. 18-19 (Dubowsky and Freudenstein's impact pair)"
    signature = "lost motion at every reversal"

    def transmission(self, port: Port, p: Values) -> Port | None:
        x, v = deadzone(port.x, p["clearance"]), port.v * outside(port.x, p["clearance"])
        return replace(port, x=x, v=v)

    def play(self, p: Values) -> sp.Expr | None:
        return p["clearance"]
