"""Coulomb friction whose level differs by direction; none at rest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import sympy as sp

from symdyn.base.nonsmooth import step
from symdyn.physics.effect import EFFORT, MECHANICAL, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema


@final
class AsymmetricCoulombFriction(Effect):
    """In a recording it is Coulomb friction with a constant offset; those two are what a diagnosis proposes."""

    identifier = "asymmetric_coulomb_friction"
    title = "direction-asymmetric Coulomb friction"
    attaches_to = MECHANICAL
    parameters = (
        ParameterSchema(
            "level_positive", EFFORT, "F_c^+", "size of the friction force where the speed is positive", lower=0.0
        ),
        ParameterSchema(
            "level_negative", EFFORT, "F_c^-", "size of the friction force where the speed is negative", lower=0.0
        ),
    )
    source = "Armstrong-Helouvry, Dupont, Canudas de Wit 1994, section 2"
    signature = "residual jumps with the sign of speed, by different amounts to either side of zero"
    rivals = ("coulomb_friction", "force_offset")
    sums = ("coulomb_friction", "force_offset"), ("coulomb_friction", "linear_spring")
    dissipative = True

    def force(self, port: Port, p: Values) -> sp.Expr:
        return p["level_negative"] * step(-port.v) - p["level_positive"] * step(port.v)

    @classmethod
    def summed(cls, parts: Mapping[str, Mapping[str, float]]) -> Mapping[str, float] | None:
        """A preload of a spring whose rest is not known is an offset."""
        level = parts["coulomb_friction"]["level"]
        offset = parts["force_offset"]["offset"] if "force_offset" in parts else -parts["linear_spring"]["preload"]
        if not 0.0 < abs(offset) <= level:
            return None
        return {"level_positive": level + offset, "level_negative": level - offset}
