"""Amplifier saturation: no more than a limit reaches the motor, in either direction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.base.nonsmooth import clip
from symdyn.physics.effect import CIRCUIT, ELECTRICAL, Effect, Values
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import Motion


@final
class AmplifierSaturation(Effect):
    """Without a limit (an infinite one) it hands on what it is given."""

    identifier = "amplifier_saturation"
    title = "amplifier saturation"
    attaches_to = CIRCUIT
    motions = ELECTRICAL
    parameters = (
        ParameterSchema("limit", {Motion.ELECTRICAL: "V"}, r"U_{\max}", "largest output", null=math.inf, lower=0.0),
    )
    proposable = True
    stage = 4
    source = "van de Ven 1986, fig. 8"
    signature = "voltage stands at a constant while the input goes on"

    def amplified(self, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return clip(control, -p["limit"], p["limit"])
