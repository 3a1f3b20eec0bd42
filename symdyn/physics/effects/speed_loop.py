"""Speed loop: a PI control unit that sets the motor's voltage."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.base.nonsmooth import clip
from symdyn.physics.effect import SPEED, HiddenState, Port, Unit, Values, mechanical
from symdyn.physics.servo_loop import SAMPLING, ServoLoop
from symdyn.spec.effect_schema import ParameterSchema


@final
class SpeedLoop(ServoLoop):
    """U = K_P (w - v) + K_I int(w - v) dt within +-limit; w is the reference, or what a position loop asks for.

    While the limit holds, the integrator follows it (back-calculation with the tracking time).
    """

    identifier = "speed_loop"
    title = "speed loop"
    parameters = (
        ParameterSchema("proportional", mechanical("V s/rad", "V s/m"), "K_P", "voltage per error", lower=0.0),
        ParameterSchema(
            "integral",
            mechanical("V/rad", "V/m"),
            "K_I",
            "voltage per error and time",
            lower=0.0,
            default=0.0,
            zero_is_structural=True,
        ),
        ParameterSchema(
            "tracking_time",
            mechanical("s", "s"),
            "T_t",
            "of the integrator after the limit",
            None,
            lower=1e-12,
            default=0.1,
        ),
        ParameterSchema("limit", mechanical("V", "V"), r"U_{\max}", "largest voltage", math.inf, lower=0.0),
        *SAMPLING,
    )
    source = "Siciliano, Sciavicco, Villani, Oriolo 2009, Robotics, section 8.3"
    hands_on = "V"

    def output(self, port: Port, p: Values, memory: Sequence[sp.Expr], reference: sp.Expr) -> sp.Expr:
        return clip(self._asked(port, p, memory, reference), -p["limit"], p["limit"])

    def memory(self, p: Values) -> tuple[HiddenState, ...]:
        return () if p["integral"] == 0 else (HiddenState("error_integral", mechanical("rad", "m"), r"\epsilon"),)

    def memory_rates(self, port: Port, p: Values, memory: Sequence[sp.Expr], reference: sp.Expr) -> tuple[sp.Expr, ...]:
        if not memory:
            return ()
        asked = self._asked(port, p, memory, reference)
        excess = asked - clip(asked, -p["limit"], p["limit"])
        return (reference - port.v - excess / (p["integral"] * p["tracking_time"]),)

    @classmethod
    def reference_unit(cls) -> Unit:
        return SPEED

    def _asked(self, port: Port, p: Values, memory: Sequence[sp.Expr], reference: sp.Expr) -> sp.Expr:
        integral = p["integral"] * memory[0] if memory else sp.Integer(0)
        return p["proportional"] * (reference - port.v) + integral
