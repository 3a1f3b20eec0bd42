"""Amplifier gain: volts at the motor per volt of its input."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import CIRCUIT, ELECTRICAL, Effect, Values
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import Motion


@final
class AmplifierGain(Effect):
    """Stages of an amplifier act one after the other, in the order in which they are declared at its circuit."""

    identifier = "amplifier_gain"
    title = "amplifier gain"
    attaches_to = CIRCUIT
    motions = ELECTRICAL
    parameters = (ParameterSchema("gain", {Motion.ELECTRICAL: "1"}, "G", "output per input", null=1.0),)
    proposable = True
    stage = 1
    source = "van de Ven 1986, fig. 8"
    signature = "a calibration: all voltages off by one factor"

    def amplified(self, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return p["gain"] * control
