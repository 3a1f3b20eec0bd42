"""Inertial parameters of a link about its frame's origin: mass, first moment, inertia tensor."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from symdyn.derive.quantities import expression
from symdyn.spec.records import InertiaAbout, Link


@dataclass(frozen=True, slots=True)
class Body:
    """``mass``, ``first_moment`` m c (3,), ``inertia`` (3, 3) about the frame's origin.

    The equations of motion are linear in these ten, which keeps them short (no m * (h / m)).
    """

    mass: sp.Expr
    com: sp.Matrix
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
        top = second.row_join(self.first_moment)
        return top.col_join(self.first_moment.T.row_join(sp.Matrix([[self.mass]])))


def body(link: Link) -> Body:
    """The steps from "about the centre of mass" (Steiner's rule) included."""
    mass = expression(link.mass)
    com = sp.Matrix([expression(entry) for entry in link.com])
    xx, yy, zz, xy, xz, yz = (expression(entry) for entry in link.inertia)
    inertia = sp.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if link.about is InertiaAbout.COM:
        inertia = inertia + mass * (com.dot(com) * sp.eye(3) - com * com.T)
    return Body(mass, com, mass * com, inertia)
