"""Which hypotheses are asked: a law that corrects another wants that one on the same drive."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from symdyn.compiler import robot_from_text
from symdyn.numeric.filtering.explain import ready
from symdyn.numeric.filtering.hypotheses import hypotheses
from tests.numeric.filtering.drive import MODEL

FLEXIBLE = MODEL.replace(
    'rotors = [ { name = "motor", inertia = "J_m", fixed_to_joint = true } ]',
    'rotors = [ { name = "motor", inertia = "J_m" } ]\n'
    'shafts = [ { name = "shaft", from = "motor", to = "joint", stiffness = "10 N m/rad", '
    'damping = "1e-3 N m s/rad" } ]',
)


def asked(text: str) -> set[tuple[str, str]]:
    robot = robot_from_text(text, "drive.toml")
    model, nothing = SimpleNamespace(robot=robot, proposed=hypotheses(robot)), SimpleNamespace(found=())
    return {(c.effect, c.place.address) for c in ready(cast(Any, model), cast(Any, nothing))}


def test_a_correction_is_asked_wherever_the_drive_has_what_it_corrects() -> None:
    there = asked(FLEXIBLE)
    assert ("asymmetric_viscous_friction", "axis") in there  # where the model has its viscous friction
    assert ("asymmetric_viscous_friction", "axis.motor") in there  # across the shaft
    assert ("viscous_friction", "axis") not in there  # the model has it
    assert ("viscous_friction", "axis.motor") in there
    assert not any(effect == "stribeck_friction" for effect, _ in there)  # of Coulomb friction, which nobody has found


def test_without_what_it_corrects_it_is_not_asked() -> None:
    where = FLEXIBLE.index('[[effect]]\ntype = "viscous_friction"')
    frictionless = FLEXIBLE[:where] + FLEXIBLE[FLEXIBLE.index('[[effect]]\ntype = "tachometer"') :]
    assert not any(effect == "asymmetric_viscous_friction" for effect, _ in asked(frictionless))
