"""Unbalance: a mass beside the axis of a rotor or joint, which gravity pulls down."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.physics.effect import MOVING, TURNING, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema, Scan
from symdyn.spec.records import Motion


@final
class Unbalance(Effect):
    """For what no link describes: a rotor, a coupling. Its inertia about the axis is counted too.

    Gravity shows mass times eccentricity; the inertia, which could tell them apart, adds to that of the part itself.
    """

    identifier = "unbalance"
    title = "unbalance"
    attaches_to = MOVING
    motions = TURNING
    parameters = (
        ParameterSchema("mass", {Motion.ROTATIONAL: "kg"}, "m_u", "mass beside the axis", lower=0.0),
        ParameterSchema(
            "eccentricity",
            {Motion.ROTATIONAL: "m"},
            "r_u",
            "its distance from the axis",
            null=None,
            lower=0.0,
            scan=Scan.ASSUMED,
            tried=(0.01,),
        ),
        ParameterSchema(
            "phase",
            {Motion.ROTATIONAL: "rad"},
            r"\varphi_u",
            "angle at which it hangs at rest",
            null=None,
            scan=Scan.ANGLE,
        ),
        ParameterSchema(
            "gravity",
            {Motion.ROTATIONAL: "m/s^2"},
            "g",
            "gravity across the axis",
            null=None,
            lower=0.0,
            default=9.81,
            scan=Scan.ASSUMED,
            tried=(9.81,),
        ),
    )
    source = "van de Ven 1986, section 5 (gravity on a link)"
    signature = "residual periodic in the angle, one wave per turn"
    rivals = ("torque_ripple", "payload", "counterbalance_spring")
    proposable = True

    def kinetic_energy(self, port: Port, p: Values) -> sp.Expr:
        return p["mass"] * p["eccentricity"] ** 2 * port.v**2 / 2

    def potential_energy(self, port: Port, p: Values) -> sp.Expr:
        return -p["mass"] * p["gravity"] * p["eccentricity"] * sp.cos(port.x - p["phase"])
