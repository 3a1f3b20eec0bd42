"""Effort saturation: no more than a limit reaches a joint that is driven by its effort, in either direction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.base.nonsmooth import clip
from symdyn.physics.effect import EFFORT, Effect, Values
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import PlaceKind


@final
class EffortSaturation(Effect):
    """Behind the gain of an actuator. Where there is a motor, its amplifier saturates instead."""

    identifier = "effort_saturation"
    title = "effort saturation"
    attaches_to = frozenset({PlaceKind.JOINT})
    parameters = (ParameterSchema("limit", EFFORT, r"\tau_{\max}", "largest effort", null=math.inf, lower=0.0),)
    stage = 4
    source = "Slotine and Li 1991, Applied Nonlinear Control, section 5.2"
    signature = "effort stands at a constant while the input goes on"
    rivals = ("amplifier_saturation",)

    def amplified(self, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return clip(control, -p["limit"], p["limit"])
