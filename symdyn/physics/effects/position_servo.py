"""Position servo: a PID control unit that sets the motor's voltage."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.base.nonsmooth import clip
from symdyn.physics.effect import DISPLACEMENT, MOVING, Effect, HiddenState, Port, Rate, Unit, Values, mechanical
from symdyn.spec.effect_schema import ParameterSchema


@final
class PositionServo(Effect):
    """U = P (r - x) + I int(r - x) dt - D v within +-limit; r is the reference, x and v are measured at its place.

    While the limit holds, the integrator follows it (back-calculation with the tracking time).
    """

    identifier = "position_servo"
    title = "position servo"
    attaches_to = MOVING
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
    )
    source = "van de Ven 1986, fig. 8; Astrom and Hagglund 1995, PID Controllers, section 3.5"

    def controls(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return clip(self._asked(port, p, z, control), -p["limit"], p["limit"])

    def hidden_states(self, p: Values) -> tuple[HiddenState, ...]:
        return () if p["integral"] == 0 else (HiddenState("integral", mechanical("rad s", "m s"), r"\epsilon"),)

    def rates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Rate, ...]:
        if not z:
            return ()
        asked = self._asked(port, p, z, control)
        return (
            Rate(
                sp.Integer(1),
                control
                - port.x
                + (clip(asked, -p["limit"], p["limit"]) - asked) / (p["integral"] * p["tracking_time"]),
            ),
        )

    def reference_unit(self) -> Unit:
        return DISPLACEMENT

    def _asked(self, port: Port, p: Values, z: Sequence[sp.Expr], reference: sp.Expr) -> sp.Expr:
        integral = p["integral"] * z[0] if z else sp.Integer(0)
        return p["proportional"] * (reference - port.x) + integral - p["derivative"] * port.v
