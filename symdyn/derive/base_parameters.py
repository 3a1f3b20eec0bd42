"""Base inertial parameters by name: the fewest numbers that the efforts of the rigid arm depend on, by rules.

A link enters through its pseudo-inertia in its joint frame (z is the joint's axis): mass ``11``, first moments ``x1``,
``y1``, ``z1``, second moments ``xx`` to ``zz``, which make the inertia tensor: I_xx = yy + zz, I_xy = -xy, and so on.
Grouping (``symdyn.derive.grouping``) hands on what a link cannot show; of the rest, what is left of it here is

- nothing that no effort contains (the first link's, but for its inertia about its own axis);
- one sum xx + yy, which is I_zz, for a link that turns about one direction alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from symdyn.derive.grouping import ENTRIES, group, name_of, parallel_axes
from symdyn.derive.joint_frames import JointFrame, joint_frames
from symdyn.derive.newton_euler import efforts
from symdyn.derive.steps import Steps
from symdyn.spec.records import Robot

UNITS = {0: "kg m^2", 1: "kg m", 2: "kg"}


@dataclass(frozen=True, slots=True)
class BaseParameter:
    """``entry`` of the grouped pseudo-inertia of ``link``, as an expression of the robot's parameters."""

    link: str
    entry: str  # "xx" to "zz", "x1" to "z1", "11"; or "xx + yy"
    expression: sp.Expr
    unit: str


def base_parameters(robot: Robot) -> tuple[BaseParameter, ...]:
    """Those of the links, from the base outwards; drives and other effects have parameters of their own."""
    chain, names, steps = joint_frames(robot), [joint.name for joint in robot.joints], Steps()
    inertias = group(chain, names, steps)
    given: dict[sp.Symbol, sp.Expr] = {}
    for step in steps.freeze():
        given[step.symbol] = sp.expand(step.expression.xreplace(given))
    visible = _visible(robot, chain, inertias)
    found = list[BaseParameter]()
    for i, (inertia, planar) in enumerate(zip(inertias, parallel_axes(chain), strict=True), start=1):
        shown = {(r, c): sp.expand(inertia[r, c].xreplace(given)) for r, c in ENTRIES if (i, r, c) in visible}
        if planar and {(0, 0), (1, 1)} & set(shown):
            total = shown.pop((0, 0), sp.Integer(0)) + shown.pop((1, 1), sp.Integer(0))
            found.append(BaseParameter(names[i - 1], "xx + yy", sp.expand(total), UNITS[0]))
        found += [
            BaseParameter(names[i - 1], name_of(i, r, c).rpartition("_")[2], value, UNITS[(r, c).count(3)])
            for (r, c), value in shown.items()
        ]
    return tuple(found)


def _visible(robot: Robot, chain: Sequence[JointFrame], inertias: Sequence[sp.Matrix]) -> set[tuple[int, int, int]]:
    """Which entries (link, row, column) reach an effort: each stands as a symbol of its own, but for zeros."""
    stands = {}
    marked = []
    for i, inertia in enumerate(inertias, start=1):
        matrix = sp.zeros(4, 4)
        for r, c in ENTRIES:
            if inertia[r, c] != 0:
                matrix[r, c] = matrix[c, r] = symbol = sp.Dummy(name_of(i, r, c), real=True)
                stands[symbol] = (i, r, c)
        marked.append(matrix)
    steps = Steps()
    needed = set().union(*(sp.expand(effort).free_symbols for effort in efforts(robot, marked, steps)))
    for step in reversed(steps.freeze()):
        if step.symbol in needed:
            needed |= sp.expand(step.expression).free_symbols
    return {place for symbol, place in stands.items() if symbol in needed}
