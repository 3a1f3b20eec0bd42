"""Amplifier offset: volts at the motor without an input."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import CIRCUIT, ELECTRICAL, Effect, Values
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import Motion


@final
class AmplifierOffset(Effect):
    """Adds to what the stages before it hand on."""

    identifier = "amplifier_offset"
    title = "amplifier offset"
    attaches_to = CIRCUIT
    motions = ELECTRICAL
    parameters = (ParameterSchema("offset", {Motion.ELECTRICAL: "V"}, "U_0", "output without input"),)
    proposable = True
    stage = 2
    source = "van de Ven 1986, fig. 8"
    signature = "the machine creeps, or stands with a current"

    def amplified(self, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return control + p["offset"]
