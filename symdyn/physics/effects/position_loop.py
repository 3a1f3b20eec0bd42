"""Position loop: the outer loop of a cascade, which asks for a speed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.base.nonsmooth import clip
from symdyn.physics.effect import DISPLACEMENT, SPEED, Port, Unit, Values, mechanical
from symdyn.physics.servo_loop import SAMPLING, ServoLoop
from symdyn.spec.effect_schema import ParameterSchema


@final
class PositionLoop(ServoLoop):
    """K_P (r - x) within +-limit, the reference of a speed loop that is declared after it."""

    identifier = "position_loop"
    title = "position loop"
    parameters = (
        ParameterSchema("proportional", mechanical("1/s", "1/s"), "K_P", "speed per error", lower=0.0),
        ParameterSchema("limit", SPEED, r"\omega_{\max}", "largest speed", math.inf, lower=0.0),
        *SAMPLING,
    )
    source = "Siciliano, Sciavicco, Villani, Oriolo 2009, Robotics, section 8.3"
    hands_on = SPEED

    def output(self, port: Port, p: Values, memory: Sequence[sp.Expr], reference: sp.Expr) -> sp.Expr:
        return clip(p["proportional"] * (reference - port.x), -p["limit"], p["limit"])

    @classmethod
    def reference_unit(cls) -> Unit:
        return DISPLACEMENT
