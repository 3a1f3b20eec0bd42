"""Payload: a point mass on the link behind a joint."""

from __future__ import annotations

from typing import final

from symdyn.physics.effect import Effect, PointMass, Values, same_unit
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import PlaceKind


@final
class Payload(Effect):
    """What has moments of inertia of its own is a ``[tool]``."""

    identifier = "payload"
    title = "payload"
    attaches_to = frozenset({PlaceKind.JOINT})
    parameters = (
        ParameterSchema("mass", same_unit("kg"), "m_p", "mass carried", lower=0.0),
        *(
            ParameterSchema(
                f"com_{axis}", same_unit("m"), f"r_{axis}", f"its {axis} in the link's frame", null=None, default=0.0
            )
            for axis in "xyz"
        ),
    )
    source = "Khalil, Gautier, Lemoine 2007, Identification of the payload inertial parameters"
    signature = "residual proportional to gravity and acceleration together"
    rivals = ("added_inertia", "unbalance")

    def body(self, p: Values) -> PointMass:
        return PointMass(p["mass"], (p["com_x"], p["com_y"], p["com_z"]))
