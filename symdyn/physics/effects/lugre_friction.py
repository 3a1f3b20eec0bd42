"""LuGre friction: bristles that bend before they slide; presliding, Stribeck effect and frictional lag in one law."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import (
    DAMPING,
    DISPLACEMENT,
    EFFORT,
    MECHANICAL,
    SPEED,
    STIFFNESS,
    Effect,
    HiddenState,
    Port,
    Rate,
    Values,
)
from symdyn.spec.effect_schema import ParameterSchema, Scan


@final
class LuGreFriction(Effect):
    """dz/dt = v - s0 |v| z / g(v), force -(s0 z + s1 dz/dt), with g = F_c + F_s exp(-(v/v_s)^2).

    Viscous friction is an effect of its own. The damping of the bristles falls with speed, as the authors
    advise: s1 / (1 + s1 |v| / (4 g)) is s1 while the bristles stick, does not matter in steady sliding,
    and keeps s1 |v| <= 4 g, without which the law would give energy (Barabanov and Ortega 2000).
    """

    identifier = "lugre_friction"
    title = "LuGre friction"
    attaches_to = MECHANICAL
    parameters = (
        ParameterSchema(
            "stiffness",
            STIFFNESS,
            r"\sigma_0",
            "stiffness of the bristles",
            lower=0.0,
            scan=Scan.STEEPNESS,
            relative_to="level",
        ),
        ParameterSchema(
            "damping",
            DAMPING,
            r"\sigma_1",
            "damping of the bristles",
            lower=0.0,
            scan=Scan.SLOWNESS,
            relative_to="level",
        ),
        ParameterSchema("level", EFFORT, "F_c", "Coulomb friction", null=None, lower=1e-12),
        ParameterSchema(
            "excess",
            EFFORT,
            "F_s",
            "excess over it at zero speed",
            null=None,
            lower=0.0,
            scan=Scan.VALUES,
            relative_to="level",
            tried=(0.2, 1.0),
        ),
        ParameterSchema(
            "stribeck_velocity",
            SPEED,
            "v_s",
            "speed at which the excess has decayed to 1/e",
            null=None,
            lower=1e-12,
            scan=Scan.SPEED,
        ),
    )
    source = "Canudas de Wit, Olsson, Astrom, Lischinsky 1995, A new model for control of systems with friction"
    signature = "residual depends on the distance since the last reversal, not on the sign of speed alone"
    rivals = ("stribeck_friction", "dahl_friction", "bouc_wen_hysteresis")
    generalises = ("coulomb_friction", "stribeck_friction", "dahl_friction")
    dissipative = True
    proposable = True

    def hidden_states(self, p: Values) -> tuple[HiddenState, ...]:
        return (HiddenState("bristle_deflection", DISPLACEMENT, "z"),)

    def rates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Rate, ...]:
        return (Rate(sp.Integer(1), port.v - p["stiffness"] * sp.Abs(port.v) * z[0] / _level(port, p)),)

    def state_force(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        (rate,) = self.rates(port, p, z, control)
        damping = p["damping"] / (1 + p["damping"] * sp.Abs(port.v) / (4 * _level(port, p)))
        return -p["stiffness"] * z[0] - damping * rate.change

    def stored_energy(self, p: Values, z: Sequence[sp.Expr]) -> sp.Expr:
        return p["stiffness"] * z[0] ** 2 / 2


def _level(port: Port, p: Values) -> sp.Expr:
    """g(v): the friction force in steady sliding."""
    return p["level"] + p["excess"] * sp.exp(-((port.v / p["stribeck_velocity"]) ** 2))
