"""Current loop: the inner loop of a cascade, an amplifier that controls the current of its motor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.base.nonsmooth import clip
from symdyn.physics.effect import CIRCUIT, ELECTRICAL, HiddenState, Port, Unit, Values
from symdyn.physics.servo_loop import ServoLoop, sampling
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import Motion


@final
class CurrentLoop(ServoLoop):
    """U = K_P (G r - I) + K_I int(G r - I) dt within +-limit; r is the command in V, or what a speed loop asks for.

    While the limit holds, the integrator follows it (back-calculation with the tracking time).
    """

    identifier = "current_loop"
    title = "current loop"
    attaches_to = CIRCUIT
    motions = ELECTRICAL
    parameters = (
        ParameterSchema("proportional", {Motion.ELECTRICAL: "V/A"}, "K_P", "voltage per error", lower=0.0),
        ParameterSchema(
            "integral",
            {Motion.ELECTRICAL: "V/A/s"},
            "K_I",
            "voltage per error and time",
            lower=0.0,
            default=0.0,
            zero_is_structural=True,
        ),
        ParameterSchema("scale", {Motion.ELECTRICAL: "A/V"}, "G", "current asked for per command", default=1.0),
        ParameterSchema(
            "tracking_time",
            {Motion.ELECTRICAL: "s"},
            "T_t",
            "of the integrator after the limit",
            None,
            lower=1e-12,
            default=0.1,
        ),
        ParameterSchema("limit", {Motion.ELECTRICAL: "V"}, r"U_{\max}", "largest voltage", math.inf, lower=0.0),
        *sampling({Motion.ELECTRICAL: "s"}),
    )
    source = "Siciliano, Sciavicco, Villani, Oriolo 2009, Robotics, section 5.2"
    hands_on = "V"

    def output(self, port: Port, p: Values, memory: Sequence[sp.Expr], reference: sp.Expr) -> sp.Expr:
        return clip(self._asked(port, p, memory, reference), -p["limit"], p["limit"])

    def memory(self, p: Values) -> tuple[HiddenState, ...]:
        return () if p["integral"] == 0 else (HiddenState("error_integral", "A s", r"\epsilon"),)

    def memory_rates(self, port: Port, p: Values, memory: Sequence[sp.Expr], reference: sp.Expr) -> tuple[sp.Expr, ...]:
        if not memory:
            return ()
        asked = self._asked(port, p, memory, reference)
        excess = asked - clip(asked, -p["limit"], p["limit"])
        return (p["scale"] * reference - port.v - excess / (p["integral"] * p["tracking_time"]),)

    @classmethod
    def reference_unit(cls) -> Unit:
        return "V"

    def _asked(self, port: Port, p: Values, memory: Sequence[sp.Expr], reference: sp.Expr) -> sp.Expr:
        integral = p["integral"] * memory[0] if memory else sp.Integer(0)
        return p["proportional"] * (p["scale"] * reference - port.v) + integral
