"""A constant force: an amplifier's offset, a preload, an unmodelled constant load."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.physics.effect import EFFORT, MOVING, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema


@final
class ForceOffset(Effect):
    """As friction, it is counted on the resisting side: positive values oppose +x."""

    identifier = "force_offset"
    title = "constant force offset"
    attaches_to = MOVING
    parameters = (ParameterSchema("offset", EFFORT, "F_0", "constant force opposing +x"),)
    source = "Janot, Gautier, Brunot 2019 (EMPS), eq. 1"
    signature = "residual has a mean"
    proposable = True

    def force(self, port: Port, p: Values) -> sp.Expr:
        return -p["offset"]
