"""Effort gain: a joint is given so many times the effort that was asked for, or that a sensor shows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import Effect, Values, same_unit
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import PlaceKind


@final
class EffortGain(Effect):
    """A torque sensor, a motor's constant or a transmission's losses: the effort alone does not tell which.

    Where there is a motor, its amplifier and its constants have gains. Declared before an ``effort_saturation``, whose
    limit is that of the effort which acts.
    """

    identifier = "effort_gain"
    title = "effort gain"
    attaches_to = frozenset({PlaceKind.JOINT})
    parameters = (
        ParameterSchema(
            "gain", same_unit("1"), r"G_{\tau}", "effort that acts, per effort that is shown", null=1.0, nonzero=True
        ),
    )
    stage = 1
    source = "Gautier and Briot 2014, Global identification of joint drive gains and dynamic parameters of robots"
    signature = "effort off by a factor, which the other joints' efforts contradict"
    rivals = ("amplifier_gain",)

    def amplified(self, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return p["gain"] * control
