"""Inertia that moves with its place: a rotor, a coupling, a gear, a carriage."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.physics.effect import INERTIA, MOVING, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema


@final
class AddedInertia(Effect):
    """Gyroscopic torques of a rotor that a moving link carries are left out, as is usual."""

    identifier = "added_inertia"
    title = "added inertia"
    attaches_to = MOVING
    parameters = (ParameterSchema("inertia", INERTIA, "J", "moment of inertia, or mass", lower=0.0),)
    source = "van de Ven 1986, eq. 11"
    signature = "residual proportional to acceleration"
    proposable = True

    def kinetic_energy(self, port: Port, p: Values) -> sp.Expr:
        return p["inertia"] * port.v**2 / 2
