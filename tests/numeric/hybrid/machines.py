"""Small machines with friction, clearance and limits, whose motion is known in closed form."""

from __future__ import annotations

from functools import cache

from symdyn.compiler import compile_hybrid, robot_from_text
from symdyn.numeric.hybrid.machine import Machine

SLIDER = """
[robot]
name = "slider"
gravity = [0, 0, 0]
[dh]
convention = "modified"
rows = [[0, "q", 0, 0]]
[[joint]]
name = "slide"
link = { mass = 2 }
"""
PAIR = """
[robot]
name = "pair"
gravity = [0, 0, 0]
[dh]
rows = [["q", 0, 0, 0]]
[[joint]]
name = "arm"
link = { inertia = { about = "joint", zz = 0.5 } }
[joint.drive]
rotors = [{ name = "motor", inertia = 0.2 }]
shafts = [{ name = "shaft", from = "motor", to = "joint", stiffness = 40, damping = 0.3 }]
"""


def effect(kind: str, at: str, **values: float) -> str:
    numbers = "\n".join(f"{name} = {value}" for name, value in values.items())
    return f'[[effect]]\ntype = "{kind}"\nat = "{at}"\n{numbers}\n'


COULOMB = effect("coulomb_friction", "slide", level=3.0)
SPRING = effect("linear_spring", "slide", stiffness=18.0)
GAP = effect("backlash", "arm.shaft", clearance=0.1)


@cache
def machine(text: str) -> Machine:
    return Machine(compile_hybrid(robot_from_text(text, "machine.toml")))
