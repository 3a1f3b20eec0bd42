"""Load-dependent friction: a gear resists in proportion to the torque that it transmits."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.base.nonsmooth import sign_of
from symdyn.physics.effect import Effect, Port, Values, same_unit
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.records import PlaceKind

MOST = 0.95  # a gear that takes more would turn under hardly any load


@final
class LoadDependentFriction(Effect):
    """At a shaft: acts on its start against the speed there, with the force of the shaft's springs as load.

    At a joint the load is what links, inertias and springs there need, which depends on the acceleration, and that on
    the friction: a loop with one solution as long as the coefficient is less than 1 (``derive/loads.py``).
    """

    identifier = "load_dependent_friction"
    title = "load-dependent friction"
    attaches_to = frozenset({PlaceKind.JOINT, PlaceKind.SHAFT})
    parameters = (
        ParameterSchema("coefficient", same_unit("1"), r"\mu", "friction per transmitted load", lower=0.0, upper=MOST),
    )
    proposable = True
    source = "Hamon, Gautier, Garrec 2010, Dynamic identification of robots with a dry friction model depending on load"
    signature = "residual jumps with the sign of speed, more under load"
    rivals = ("coulomb_friction",)
    dissipative = True

    def seat(self, port: Port) -> Port:
        return port if port.start is None else port.start

    def force(self, port: Port, p: Values) -> sp.Expr:
        return -p["coefficient"] * sp.Abs(port.load) * sign_of(port.v)
