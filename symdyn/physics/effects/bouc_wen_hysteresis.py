"""Bouc-Wen hysteresis: the loop of torque against twist of a harmonic drive, of any roundness."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import DISPLACEMENT, EFFORT, MECHANICAL, Effect, HiddenState, Port, Rate, Values, same_unit
from symdyn.spec.effect_schema import ParameterSchema, Scan


@final
class BoucWenHysteresis(Effect):
    """D dw/dt = v - b |v| |w|^(n-1) w + (b - 1) v |w|^n, force -F w: the normalised form, -1 <= w <= 1.

    Passive for b >= 1/2. With b = 1 and n = 1 it is Dahl's law; a large n has sharp corners. The elastic
    share of a shaft is a spring of its own, beside it.
    """

    identifier = "bouc_wen_hysteresis"
    title = "Bouc-Wen hysteresis"
    attaches_to = MECHANICAL
    parameters = (
        ParameterSchema("level", EFFORT, "F_h", "half the height of the loop", lower=0.0),
        ParameterSchema(
            "yield_displacement",
            DISPLACEMENT,
            "D",
            "level over initial stiffness",
            null=None,
            lower=1e-12,
            scan=Scan.DISPLACEMENT,
        ),
        ParameterSchema(
            "shape",
            same_unit("1"),
            r"\beta",
            "1: unloading as steep as loading began",
            null=None,
            lower=0.5,
            scan=Scan.VALUES,
            tried=(0.5, 0.7, 1.0, 2.0),
        ),
        ParameterSchema(
            "exponent",
            same_unit("1"),
            "n",
            "sharpness of the corners",
            null=None,
            lower=1.0,
            upper=9.0,
            default=1.0,
            is_count=True,
            tried=(1.0, 2.0, 3.0),
        ),
    )
    source = "Wen 1976; normalised by Ikhouane and Rodellar 2007, Systems with Hysteresis"
    signature = "residual is a loop over position (at a shaft: over twist), the same at any speed"
    rivals = ("dahl_friction", "lugre_friction", "coulomb_friction")
    generalises = ("coulomb_friction", "dahl_friction")
    dissipative = True
    proposable = True

    def hidden_states(self, p: Values) -> tuple[HiddenState, ...]:
        return (HiddenState("hysteresis", "1", "w"),)

    def rates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Rate, ...]:
        (w,) = z
        n, shape = p["exponent"], p["shape"]
        loading = shape * sp.Abs(port.v) * sp.Abs(w) ** (n - 1) * w
        return (Rate(p["yield_displacement"], port.v - loading + (shape - 1) * port.v * sp.Abs(w) ** n),)

    def state_force(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return -p["level"] * z[0]

    def stored_energy(self, p: Values, z: Sequence[sp.Expr]) -> sp.Expr:
        return p["level"] * p["yield_displacement"] * z[0] ** 2 / 2
