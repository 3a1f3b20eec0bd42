"""Counterbalance: a coil spring between a point of the base and a point of the link, against gravity."""

from __future__ import annotations

from typing import final

import sympy as sp

from symdyn.physics.effect import TURNING, Effect, Port, Values
from symdyn.spec.effect_schema import ParameterSchema, Scan
from symdyn.spec.records import Motion, PlaceKind

_LENGTH = {Motion.ROTATIONAL: "m"}
_ANCHOR = 1.0  # m, where only ratios of lengths can be told


@final
class CounterbalanceSpring(Effect):
    """Its length is the third side of a triangle, whose other two sides meet in the joint's axis.

    With a free length of zero it balances a link exactly: its torque is then a sine of the angle. Lengths show in the
    torque by their ratios alone; a diagnosis takes the anchor's distance as known.
    """

    identifier = "counterbalance_spring"
    title = "counterbalance spring"
    attaches_to = frozenset({PlaceKind.JOINT})
    motions = TURNING
    parameters = (
        ParameterSchema("stiffness", {Motion.ROTATIONAL: "N/m"}, "c_b", "force per extension", lower=0.0),
        ParameterSchema(
            "anchor",
            _LENGTH,
            "a_b",
            "distance of the fixed end from the axis",
            null=None,
            lower=1e-12,
            scan=Scan.ASSUMED,
            tried=(_ANCHOR,),
        ),
        ParameterSchema(
            "arm",
            _LENGTH,
            "r_b",
            "distance of the moving end from the axis",
            null=None,
            lower=1e-12,
            scan=Scan.VALUES,
            tried=(0.2 * _ANCHOR, 0.4 * _ANCHOR, 0.7 * _ANCHOR),
        ),
        ParameterSchema(
            "free_length",
            _LENGTH,
            r"\ell_b",
            "length without force",
            null=None,
            lower=0.0,
            scan=Scan.VALUES,
            tried=(0.0, 0.3 * _ANCHOR, 0.6 * _ANCHOR, 0.9 * _ANCHOR),
        ),
        ParameterSchema(
            "dead_centre",
            {Motion.ROTATIONAL: "rad"},
            r"\varphi_b",
            "angle at which both ends are closest",
            null=None,
            scan=Scan.ANGLE,
        ),
    )
    source = "Herder 2001, Energy-free Systems"
    signature = "residual a wave of the position, one per turn"
    rivals = ("unbalance", "torsion_spring")
    generalises = ("unbalance", "linear_spring")  # the latter nearly, about a dead centre
    proposable = True

    def potential_energy(self, port: Port, p: Values) -> sp.Expr:
        a, r = p["anchor"], p["arm"]
        # The cosine rule as a sum of squares, which rounding cannot make negative.
        length = sp.sqrt((a - r) ** 2 + 4 * a * r * sp.sin((port.x - p["dead_centre"]) / 2) ** 2)
        return p["stiffness"] * (length - p["free_length"]) ** 2 / 2
