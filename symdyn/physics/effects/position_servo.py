"""Position servo: a PID control unit that sets the motor's voltage."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.base.nonsmooth import clip
from symdyn.physics.effect import DISPLACEMENT, HiddenState, Port, Unit, Values, mechanical
from symdyn.physics.servo_loop import SAMPLING, ServoLoop
from symdyn.spec.effect_schema import ParameterSchema


@final
class PositionServo(ServoLoop):
    """U = P (r - x) + I int(r - x) dt - D v within +-limit; r is the reference, x and v are measured at its place.

    While the limit holds, the integrator follows it (back-calculation with the tracking time).
    """

    identifier = "position_servo"
    title = "position servo"
    parameters = (
        ParameterSchema("proportional", mechanical("V/rad", "V/m"), "K_P", "voltage per error", lower=0.0),
        ParameterSchema(
            "integral",
            mechanical("V/rad/s", "V/m/s"),
            "K_I",
            "voltage per error and time",
            lower=0.0,
            default=0.0,
            zero_is_structural=True,
        ),
        ParameterSchema(
            "derivative",
            mechanical("V s/rad", "V s/m"),
            "K_D",
            "voltage per speed",
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
    source = "van de Ven 1986, fig. 8; Astrom and Hagglund 1995, PID Controllers, section 3.5"
    hands_on = "V"

    def output(self, port: Port, p: Values, memory: Sequence[sp.Expr], reference: sp.Expr) -> sp.Expr:
        return clip(self._asked(port, p, memory, reference), -p["limit"], p["limit"])

    def memory(self, p: Values) -> tuple[HiddenState, ...]:
        return () if p["integral"] == 0 else (HiddenState("error_integral", mechanical("rad s", "m s"), r"\epsilon"),)

    def memory_rates(self, port: Port, p: Values, memory: Sequence[sp.Expr], reference: sp.Expr) -> tuple[sp.Expr, ...]:
        if not memory:
            return ()
        asked = self._asked(port, p, memory, reference)
        excess = asked - clip(asked, -p["limit"], p["limit"])
        return (reference - port.x - excess / (p["integral"] * p["tracking_time"]),)

    @classmethod
    def reference_unit(cls) -> Unit:
        return DISPLACEMENT

    def _asked(self, port: Port, p: Values, memory: Sequence[sp.Expr], reference: sp.Expr) -> sp.Expr:
        integral = p["integral"] * memory[0] if memory else sp.Integer(0)
        return p["proportional"] * (reference - port.x) + integral - p["derivative"] * port.v
