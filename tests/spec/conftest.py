"""A small catalogue of effects, so that reading is tested apart from the physics; and a small valid robot."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from symdyn.spec.effect_schema import EffectSchema, ParameterSchema
from symdyn.spec.records import Motion, PlaceKind

ROTATIONAL, TRANSLATIONAL = Motion.ROTATIONAL, Motion.TRANSLATIONAL
MOVING = frozenset({PlaceKind.JOINT, PlaceKind.INERTIA, PlaceKind.SHAFT})
EFFORT = {ROTATIONAL: "N m", TRANSLATIONAL: "N"}

VALID = """\
[robot]
name = "arm"
gravity = [0, 0, -9.81]

[parameters]
m_2 = "3 kg"
l_2 = { value = 400, unit = "mm" }

[dh]
rows = [ ["q", 0, 0.5, 0],
         ["q", 0, "l_2", "90 deg"] ]

[[joint]]
name = "shoulder"
link = { mass = 4, com = [-0.25, 0, 0], inertia = { about = "com", zz = "0.08 kg m^2" } }

[[joint]]
name = "elbow"
link = { mass = "m_2", com = ["-1/2 l_2", 0, 0], inertia = { yy = "1/12 m_2 l_2^2", zz = "1/12 m_2 l_2^2" } }

[joint.drive]
ratio = 100
rotors = [ { name = "motor", inertia = "5e-5 kg m^2" } ]
shafts = [ { name = "belt", from = "motor", to = "joint", stiffness = 12, damping = "0.1 mNms/rad" } ]
motor = { name = "circuit", at = "motor", resistance = "1.6 Ohm", inductance = "87 uH", \
torque_constant = "0.05 Nm/A", back_emf_constant = "0.05 V s/rad" }

[[effect]]
type = "viscous_friction"
at = "elbow.motor"
coefficient = 1e-5
"""


def _effect(
    identifier: str,
    attaches_to: frozenset[PlaceKind],
    *parameters: ParameterSchema,
    reference: Mapping[Motion, str] | None = None,
) -> EffectSchema:
    return EffectSchema(identifier, identifier.replace("_", " "), attaches_to, parameters, reference)


CATALOGUE = {
    effect.identifier: effect
    for effect in (
        _effect(
            "tachometer",
            frozenset({PlaceKind.INERTIA}),
            ParameterSchema(
                "constant", {ROTATIONAL: "V s/rad"}, "K_{Et}", "tachometer constant", null=None, nonzero=True
            ),
        ),
        _effect(
            "viscous_friction",
            MOVING,
            ParameterSchema(
                "coefficient", {ROTATIONAL: "N m s/rad", TRANSLATIONAL: "N s/m"}, "F_v", "viscous friction", lower=0.0
            ),
        ),
        _effect(
            "coulomb_friction", MOVING, ParameterSchema("level", EFFORT, "F_c", "Coulomb friction level", lower=0.0)
        ),
        _effect(
            "asymmetric_coulomb_friction",
            MOVING,
            ParameterSchema("level_positive", EFFORT, "F_c^+", "Coulomb friction level forwards", lower=0.0),
            ParameterSchema("level_negative", EFFORT, "F_c^-", "Coulomb friction level backwards", lower=0.0),
        ),
        _effect(
            "added_inertia",
            MOVING,
            ParameterSchema("inertia", {ROTATIONAL: "kg m^2", TRANSLATIONAL: "kg"}, "J", "inertia, or mass", lower=0.0),
        ),
        _effect(
            "stribeck_friction",
            MOVING,
            ParameterSchema("level", EFFORT, "F_s", "static friction level", lower=0.0),
            ParameterSchema(
                "exponent", {ROTATIONAL: "1", TRANSLATIONAL: "1"}, r"\delta", "shape", lower=0.5, upper=2.0, default=2.0
            ),
        ),
        _effect(
            "position_servo",
            MOVING,
            ParameterSchema("proportional", {ROTATIONAL: "V/rad"}, "K_P", "voltage per error", lower=0.0),
            ParameterSchema("derivative", {ROTATIONAL: "V s/rad"}, "K_D", "voltage per speed", default=0.0),
            ParameterSchema("limit", {ROTATIONAL: "V"}, "U", "largest voltage", null=None, lower=0.0),
            reference={ROTATIONAL: "rad", TRANSLATIONAL: "m"},
        ),
        _effect(
            "backlash",
            frozenset({PlaceKind.SHAFT}),
            ParameterSchema("clearance", {ROTATIONAL: "rad", TRANSLATIONAL: "m"}, "S", "clearance", lower=0.0),
        ),
    )
}


@pytest.fixture(scope="session")
def catalogue() -> dict[str, EffectSchema]:
    return CATALOGUE


@pytest.fixture(scope="session")
def valid() -> str:
    """A valid robot of two joints with literals, parameters, a drive and an effect."""
    return VALID
