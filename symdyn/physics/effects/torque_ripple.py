"""Torque ripple: cogging of a motor, eccentric gears; a force periodic in the angle."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.physics.effect import EFFORT, MOVING, Effect, Port, Values, mechanical
from symdyn.spec.effect_schema import ParameterSchema, Scan


@final
class TorqueRipple(Effect):
    """Derived from a potential, so that it neither gives nor takes energy over a turn."""

    identifier = "torque_ripple"
    title = "torque ripple (cogging)"
    attaches_to = MOVING
    parameters = (
        ParameterSchema("cosine", EFFORT, "A_c", "amplitude of the cosine of the angle times the order"),
        ParameterSchema("sine", EFFORT, "A_s", "amplitude of the sine of the angle times the order"),
        ParameterSchema(
            "order",
            mechanical("rad/rad", "rad/m"),
            "n",
            "waves per turn (per 2 pi metres on a prismatic axis)",
            null=None,
            lower=1e-12,
            scan=Scan.ANGLE_ORDER,
        ),
    )
    source = "Hanselman 2003, Brushless Permanent Magnet Motor Design"
    signature = "residual periodic in the angle"
    proposable = True

    def potential_energy(self, port: Port, p: Values) -> sp.Expr:
        n = p["order"]
        return (p["sine"] * sp.cos(n * port.x) - p["cosine"] * sp.sin(n * port.x)) / n
