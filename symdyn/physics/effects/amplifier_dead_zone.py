"""Amplifier dead zone: small inputs give nothing, and larger ones are short of it (crossover distortion)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.base.nonsmooth import deadzone
from symdyn.physics.effect import CIRCUIT, ELECTRICAL, Effect, Values
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import Motion


@final
class AmplifierDeadZone(Effect):
    """Of an output stage whose transistors take over late from each other."""

    identifier = "amplifier_dead_zone"
    title = "amplifier dead zone"
    attaches_to = CIRCUIT
    motions = ELECTRICAL
    parameters = (
        ParameterSchema("half_width", {Motion.ELECTRICAL: "V"}, "U_d", "largest input without output", lower=0.0),
    )
    proposable = True
    stage = 3  # one that is not the same both ways is that of an input with an offset
    source = "Slotine and Li 1991, Applied Nonlinear Control, section 5.2"
    signature = "odd distortion that fades with amplitude"

    def amplified(self, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return deadzone(control, p["half_width"])
