"""Base inertial parameters by name: the fewest numbers that the efforts of the rigid arm depend on, by rules.

A link enters through its pseudo-inertia in its joint frame (z is the joint's axis): mass ``1``, first moments ``x``,
``y``, ``z``, second moments ``xx`` to ``zz``, which make the inertia tensor: I_xx = yy + zz, I_xy = -xy, and so on.
Grouping (``symdyn.derive.grouping``) hands on what a link cannot show; of the rest, what is left of it here is

- nothing that no effort contains (the first link's, but for its inertia about its own axis);
- one sum xx + yy, which is I_zz, for a link that turns about one direction alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from symdyn.derive.grouping import ENTRIES, name_of
from symdyn.derive.joint_frames import JointFrame, joint_frames
from symdyn.derive.newton_euler import inverse_dynamics
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot

UNITS = {0: "kg m^2", 1: "kg m", 2: "kg"}


@dataclass(frozen=True, slots=True)
class BaseParameter:
    """``entry`` of the grouped pseudo-inertia of ``link``, as an expression of the robot's parameters."""

    name: str  # as in the steps of the derivation: J_2_xx
    link: str
    entry: str
    expression: sp.Expr
    unit: str


def base_parameters(robot: Robot) -> tuple[BaseParameter, ...]:
    """Those of the links, from the base outwards; drives and other effects have parameters of their own."""
    steps, names = Steps(), [joint.name for joint in robot.joints]
    efforts = inverse_dynamics(robot, steps)
    moments = {name_of(i, r, c) for i in range(1, len(names) + 1) for r, c in ENTRIES}
    needed = set().union(*(effort.free_symbols for effort in efforts))
    given: dict[sp.Symbol, sp.Expr] = {}
    for step in steps.freeze():
        if step.symbol.name in moments:
            given[step.symbol] = sp.expand(step.expression.xreplace(given))
    for step in reversed(steps.freeze()):
        if step.symbol in needed and step.symbol not in given:
            needed |= step.expression.free_symbols
    chain, found = joint_frames(robot), list[BaseParameter]()
    for i, (link, planar) in enumerate(zip(names, _turning_about_one_direction(chain), strict=True), start=1):
        for r, c in ENTRIES:
            symbol = sp.Symbol(name_of(i, r, c), real=True)
            if symbol not in needed or symbol not in given:
                continue
            name, expression = symbol.name, given[symbol]
            if planar and (r, c) == (0, 0):
                other = sp.Symbol(name_of(i, 1, 1), real=True)
                name, expression = f"{name} + {other.name}", sp.expand(expression + given.get(other, other))
            elif planar and (r, c) == (1, 1):
                continue
            found.append(BaseParameter(name, link, name_of(i, r, c).rpartition("_")[2], expression, UNITS[(r, c).count(3)]))
    return tuple(found)


def _turning_about_one_direction(chain: Sequence[JointFrame]) -> list[bool]:
    """For each revolute link, whether the axes of all revolute joints before it are parallel to its own."""
    found, along = [], None  # the common direction, in the frame that was reached
    parallel = True
    for frame in chain:
        direction = None if along is None else frame.twist.T * along
        if frame.prismatic:
            if direction is not None:
                c, s = sp.cos(frame.angle), sp.sin(frame.angle)
                along = sp.Matrix([[c, s, 0], [-s, c, 0], [0, 0, 1]]) * direction
            found.append(False)
            continue
        if direction is not None:
            parallel = parallel and sp.simplify(direction[0]) == 0 and sp.simplify(direction[1]) == 0
        along = sp.Matrix([0, 0, 1])
        found.append(parallel)
    return found
