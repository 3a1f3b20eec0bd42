"""The seed's drive without its jumps, and chains of inertias with letters chosen by a test."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

from symdyn.base.linear_system import LinearFamily
from symdyn.compiler import linearise, load_robot, robot_from_text
from symdyn.derive.linearize import without_nonsmooth


@cache
def drive() -> LinearFamily:
    return linearise(without_nonsmooth(load_robot("irb6-axis1")))


def chain_text(inertias: list[float], stiffnesses: list[float], dampings: list[float], grounded: float = 0.0) -> str:
    """Rotors r1, r2, ... on shafts s1, s2, ..., the last inertia the joint's; ``grounded`` dampens the first rotor."""
    last = len(inertias)
    names = [*(f"r{i}" for i in range(1, last)), "joint"]
    rotors = ", ".join(f'{{ name = "r{i}", inertia = "J_{i}" }}' for i in range(1, last))
    shafts = ", ".join(
        f'{{ name = "s{i}", from = "{a}", to = "{b}", stiffness = "c_{i}", damping = "d_{i}" }}'
        for i, (a, b) in enumerate(pairwise(names), start=1)
    )
    values = [f'J_{i} = "{v!r} kg m^2"' for i, v in enumerate(inertias, start=1)]
    values += [f'c_{i} = "{v!r} N m/rad"' for i, v in enumerate(stiffnesses, start=1)]
    values += [f'd_{i} = "{v!r} N m s/rad"' for i, v in enumerate(dampings, start=1)]
    parameters = "\n".join(values)
    return f"""\
[robot]
name = "chain"
gravity = [0, 0, 0]
[parameters]
{parameters}
b = "{grounded!r} N m s/rad"
[dh]
rows = [["q", 0, 0, 0]]
[[joint]]
name = "load"
link = {{ inertia = {{ about = "joint", zz = "J_{last}" }} }}
[joint.drive]
ratio = 1
rotors = [{rotors}]
shafts = [{shafts}]
[[effect]]
type = "viscous_friction"
at = "load.r1"
coefficient = "b"
"""


def chain(
    inertias: list[float], stiffnesses: list[float], dampings: list[float], grounded: float = 0.0
) -> LinearFamily:
    return linearise(robot_from_text(chain_text(inertias, stiffnesses, dampings, grounded), "chain.toml"))
