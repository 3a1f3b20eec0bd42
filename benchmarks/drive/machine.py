"""The drive of the 1986 paper with a clearance and a servo loop, from its file."""

from __future__ import annotations

from functools import cache

from symdyn.compiler import compile_hybrid, load_robot, robot_from_text
from symdyn.numeric.hybrid.machine import Machine

SERVO = """
[[effect]]
type = "position_servo"
at = "axis1.motor"
proportional = "50 V/rad"
derivative = "0.5 V s/rad"
limit = "24 V"
"""


@cache
def seed_drive() -> Machine:
    text = load_robot("irb6-axis1").text.replace('S = "0 rad" ', 'S = "0.01 rad" ')
    return Machine(compile_hybrid(robot_from_text(text + SERVO, "drive.toml")))
