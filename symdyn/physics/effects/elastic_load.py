"""Elastic load: an inertia behind a spring and a damper, of which nothing is measured."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import sympy as sp

from symdyn.physics.effect import (
    DISPLACEMENT,
    INERTIA,
    MOVING,
    SPEED,
    Effect,
    HiddenState,
    Port,
    Rate,
    Values,
    same_unit,
)
from symdyn.spec.effect_schema import ParameterSchema, Scan


@final
class ElasticLoad(Effect):
    """J dw/dt = J (omega^2 x + 2 zeta omega dx/dt) with dx/dt = v - w, which is also what the place is held back by.

    Seen from a motor: a compliant transmission, its load beyond; seen from a joint: a link that bends, a hanging load.
    ``frequency`` is that at which the load swings while the place is held, the anti-resonance. It has no weight.
    """

    identifier = "elastic_load"
    title = "elastic load"
    attaches_to = MOVING
    parameters = (
        ParameterSchema("inertia", INERTIA, "J_e", "moment of inertia, or mass, behind the spring", lower=0.0),
        ParameterSchema(
            "frequency",
            same_unit("rad/s"),
            r"\omega_e",
            "of the load while the place is held: the root of stiffness over inertia",
            null=None,
            lower=1e-12,
            scan=Scan.FREQUENCY,
        ),
        ParameterSchema(
            "damping_ratio",
            same_unit("1"),
            r"\zeta_e",
            "damping of that, as a share of the critical one",
            null=None,
            lower=0.0,
            scan=Scan.DAMPING,
            tried=(0.002, 0.05, 0.4),
        ),
    )
    source = "Spong 1987, Modeling and control of elastic joint robots; van de Ven 1986, section 5 (bending)"
    signature = "residual rings at one frequency: an anti-resonance and a resonance above it"
    rivals = ("added_inertia",)
    generalises = ("added_inertia",)
    dissipative = True
    proposable = True

    def hidden_states(self, p: Values) -> tuple[HiddenState, ...]:
        return (HiddenState("load_deflection", DISPLACEMENT, r"\xi"), HiddenState("load_speed", SPEED, r"\nu"))

    def rates(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> tuple[Rate, ...]:
        return Rate(sp.Integer(1), port.v - z[1]), Rate(sp.Integer(1), _acceleration(port, p, z))

    def state_force(self, port: Port, p: Values, z: Sequence[sp.Expr], control: sp.Expr) -> sp.Expr:
        return -p["inertia"] * _acceleration(port, p, z)

    def stored_energy(self, p: Values, z: Sequence[sp.Expr]) -> sp.Expr:
        return p["inertia"] * (z[1] ** 2 + (p["frequency"] * z[0]) ** 2) / 2


def _acceleration(port: Port, p: Values, z: Sequence[sp.Expr]) -> sp.Expr:
    """Of the load."""
    return p["frequency"] ** 2 * z[0] + 2 * p["damping_ratio"] * p["frequency"] * (port.v - z[1])
