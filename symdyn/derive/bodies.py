"""Inertial parameters of each link about its frame's origin: mass, first moment, inertia tensor."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from symdyn.derive.kinematics import fixed
from symdyn.derive.quantities import effect_values, expression
from symdyn.physics import effect
from symdyn.physics.effect import PointMass
from symdyn.spec.records import InertiaAbout, Link, Robot


@dataclass(frozen=True, slots=True)
class Body:
    """``mass``, ``first_moment`` m c (3,), ``inertia`` (3, 3) about the frame's origin.

    The equations of motion are linear in these ten, which keeps them short (no m * (h / m)).
    """

    mass: sp.Expr
    first_moment: sp.Matrix
    inertia: sp.Matrix

    @property
    def massless(self) -> bool:
        return self.mass == 0 and self.inertia.is_zero_matrix is True

    @property
    def pseudo_inertia(self) -> sp.Matrix:
        """J_i of seed eq. 6, 4 x 4: the integral of p p^T dm over homogeneous points p."""
        xx, yy, zz = (self.inertia[i, i] for i in range(3))
        second = -self.inertia + sp.diag(*[(xx + yy + zz) / 2] * 3)
        second = second.applyfunc(sp.expand)  # half of what Steiner's rule added falls out again
        top = second.row_join(self.first_moment)
        return top.col_join(self.first_moment.T.row_join(sp.Matrix([[self.mass]])))


def bodies(robot: Robot) -> tuple[Body, ...]:
    """One body per joint, in its link's frame, with what effects put on it; that of the last link carries the tool."""
    found = [body(joint.link) for joint in robot.joints]
    if robot.tool is not None and not (tool := body(robot.tool.link)).massless:
        found[-1] = _joined(found[-1], _seen_from(tool, *fixed(robot.tool.placement)))
    at = {joint.name: i for i, joint in enumerate(robot.joints)}
    for declared in robot.effects:
        item = effect(declared.type)
        carried = item.body(effect_values(item, declared.values))
        if carried is not None:
            i = at[declared.at]
            found[i] = _joined(found[i], _point(carried))
    return tuple(found)


def _point(carried: PointMass) -> Body:
    position = sp.Matrix(carried.position)
    inertia = carried.mass * (position.dot(position) * sp.eye(3) - position * position.T)
    return Body(carried.mass, carried.mass * position, inertia)


def _joined(first: Body, second: Body) -> Body:
    """Two bodies in one frame, fixed to each other."""
    return Body(first.mass + second.mass, first.first_moment + second.first_moment, first.inertia + second.inertia)


def _seen_from(link: Body, position: sp.Matrix, rotation: sp.Matrix) -> Body:
    """A body in the frame in which its own frame is at ``position`` (3,) and ``rotation`` (3, 3)."""
    h = rotation * link.first_moment
    cross = position * h.T
    shift = (2 * position.dot(h) + link.mass * position.dot(position)) * sp.eye(3)
    inertia = rotation * link.inertia * rotation.T + shift - cross - cross.T - link.mass * position * position.T
    return Body(link.mass, h + link.mass * position, inertia)


def body(link: Link) -> Body:
    """The steps from "about the centre of mass" (Steiner's rule) included."""
    mass = expression(link.mass)
    com = sp.Matrix([expression(entry) for entry in link.com])
    xx, yy, zz, xy, xz, yz = (expression(entry) for entry in link.inertia)
    inertia = sp.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if link.about is InertiaAbout.COM:
        inertia = inertia + mass * (com.dot(com) * sp.eye(3) - com * com.T)
    return Body(mass, mass * com, inertia)
