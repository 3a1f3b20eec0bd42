"""Hardening hysteresis: a loop of force against displacement that grows stiffer as it loads."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import (
    DISPLACEMENT,
    MECHANICAL,
    STIFFNESS,
    Effect,
    HiddenState,
    Port,
    Rate,
    Values,
    same_unit,
)
from symdyn.spec.effect_schema import ParameterSchema, Scan


@final
class HardeningHysteresis(Effect):
    """D dw/dt = v + (1 + r)/2 v |w| - (r - 1)/2 |v| w, force -k D w: stiffness k (1 + |w|) loading, k (1 + r |w|) back.

    The law of Bouc and Wen with an exponent of 1 where its loop has no level: their beta + gamma is -1/D, beta
    (r - 1) / 2 D. Passive for r >= 1; with r = 1 it is a spring.
    """

    identifier = "hardening_hysteresis"
    title = "hardening hysteresis"
    attaches_to = MECHANICAL
    parameters = (
        ParameterSchema("stiffness", STIFFNESS, "k_h", "stiffness at a change of sign of the force", lower=0.0),
        ParameterSchema(
            "displacement",
            DISPLACEMENT,
            "D",
            "the force is k D where loading has doubled the stiffness",
            null=None,
            lower=1e-12,
            scan=Scan.GROWTH,
        ),
        ParameterSchema(
            "ratio",
            same_unit("1"),
            "r",
            "how many times as fast the stiffness changes on the way back",
            null=None,
            lower=1.0,
            scan=Scan.VALUES,
            tried=(1.0, 2.0, 5.0),
        ),
    )
    source = "Wen 1976; its hardening branch: Ismail, Ikhouane, Rodellar 2009, The hysteresis Bouc-Wen model, a survey"
    signature = "residual is a loop over position (at a shaft: over twist) that is steeper the farther out it is"
    rivals = ("bouc_wen_hysteresis", "hardening_spring")
    generalises = ("linear_spring",)
    opens = False  # beside dry friction and a spring it is rare, and resembles both
    dissipative = True
    proposable = True

    def hidden_states(self, p: Values) -> tuple[HiddenState, ...]:
        return (HiddenState("hysteresis", "1", "w"),)

    def rates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Rate, ...]:
        (w,) = z
        both, apart = (p["ratio"] + 1) / 2, (p["ratio"] - 1) / 2
        return (Rate(p["displacement"], port.v + both * port.v * sp.Abs(w) - apart * sp.Abs(port.v) * w),)

    def state_force(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return -p["stiffness"] * p["displacement"] * z[0]

    def stored_energy(self, p: Values, z: Sequence[sp.Expr]) -> sp.Expr:
        """What comes back on the way to no force."""
        size, r = sp.Abs(z[0]), p["ratio"]
        return p["stiffness"] * p["displacement"] ** 2 * (size / r - sp.log(1 + r * size) / r**2)
