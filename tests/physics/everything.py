"""A machine that has every effect of the catalogue at once, made from what they declare."""

from __future__ import annotations

from collections.abc import Iterator

from symdyn.compiler import robot_from_text
from symdyn.physics import catalogue, load_dependent
from symdyn.spec.effect_schema import ParameterSchema
from symdyn.spec.places import places
from symdyn.spec.records import Place, Robot

BARE = """\
[robot]
name = "everything"
gravity = [0, -9.81, 0.5]

[dh]
convention = "modified"
rows = [ ["q", 0, 0, 0], [0, "q", 0.4, "-90 deg"] ]

[[joint]]
name = "turns"
link = { mass = 2, com = [0.1, 0, 0], inertia = { xx = 0.1, yy = 0.3, zz = 0.3 } }

[joint.drive]
ratio = 3
rotors = [ { name = "motor", inertia = 0.05 }, { name = "gear", inertia = 0.02 } ]
shafts = [
  { name = "coupling", from = "motor", to = "gear", stiffness = 7, damping = 0.2 },
  { name = "belt", from = "gear", to = "joint", stiffness = 5, damping = 0.3 },
]
motor = { name = "circuit", at = "motor", resistance = 1.5, inductance = 0.2, torque_constant = 0.9, \
back_emf_constant = 0.8 }

[[joint]]
name = "slides"
link = { mass = 1.2 }

[joint.drive]
ratio = -2
rotors = [ { name = "rotor", inertia = 0.04, fixed_to_joint = true } ]
"""


def value(parameter: ParameterSchema, k: int) -> float:
    """Within its bounds and away from null, another one for each ``k``."""
    if parameter.is_count:
        return 2.0
    lower = parameter.lower or 0.0
    return round(lower + 0.3 + 0.07 * (k % 6), 4)


def blocks() -> Iterator[str]:
    """An [[effect]] for every effect, each at another of the places that it attaches to; motors are there."""
    robot = robot_from_text(BARE, "bare")
    for k, (identifier, effect) in enumerate(catalogue().items()):
        fitting = [p for p in places(robot) if p.kind in effect.attaches_to and p.motion in effect.motions]
        if identifier in ("effort_gain", "effort_saturation"):
            fitting = [place for place in fitting if place.address == "slides"]  # which has no motor
        if effect.stage < 0:  # ahead of the loops of a joint that has one
            fitting = [place for place in fitting if place.address == "slides"]
        if identifier in load_dependent():
            fitting = [place for place in fitting if "." in place.address]  # the load of a joint is no law of its port
        if identifier != "dc_motor":
            yield block(identifier, fitting[k % len(fitting)])


def block(identifier: str, place: Place) -> str:
    parameters = catalogue()[identifier].parameters
    lines = [f"{p.name} = {value(p, k + len(identifier))}" for k, p in enumerate(parameters)]
    return "\n".join(["", "[[effect]]", f'type = "{identifier}"', f'at = "{place.address}"', *lines, ""])


def everything() -> Robot:
    return robot_from_text(BARE + "".join(blocks()), "everything")
