"""Lagrange's equations of the arm in trace form (seed eq. 5-9): B_ij, C_ijk, D_i, each by itself."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import sympy as sp

from symdyn.derive.bodies import bodies
from symdyn.derive.coordinates import Coordinate, joint_coordinates
from symdyn.derive.kinematics import base_transforms
from symdyn.derive.quantities import effect_values, expression
from symdyn.physics import effect
from symdyn.spec.records import Robot


@dataclass(frozen=True, slots=True)
class LagrangeCoefficients:
    """``tau_i = B[i][j] qdd_j + C[i][j][k] qd_j qd_k + D[i]``, sums over j and k.

    B_ii is the effective inertia at joint i, B_ij the coupling inertia, C_ijj the centripetal and
    C_ijk the Coriolis coefficient (C_ijk = C_ikj: the product of two speeds counts twice), D_i gravity.
    """

    axes: tuple[Coordinate, ...]
    B: sp.Matrix
    C: tuple[sp.Matrix, ...]  # C[i][j, k]
    D: tuple[sp.Expr, ...]

    def efforts(self) -> tuple[sp.Expr, ...]:
        """(n,) joint efforts, seed eq. 9."""
        qd = sp.Matrix([c.qd for c in self.axes])
        qdd = sp.Matrix([c.qdd for c in self.axes])
        return tuple((self.B[i, :] * qdd)[0] + (qd.T * self.C[i] * qd)[0] + self.D[i] for i in range(len(self.axes)))

    def simplified(self) -> LagrangeCoefficients:
        """The same in textbook form: for people and small robots (the cost grows fast with the joints)."""
        return LagrangeCoefficients(
            self.axes,
            self.B.applyfunc(readable),
            tuple(matrix.applyfunc(readable) for matrix in self.C),
            tuple(readable(entry) for entry in self.D),
        )


def readable(expression: sp.Expr) -> sp.Expr:
    """Shortest of a few trigonometric normal forms; equal to the input."""
    expanded = sp.expand(expression)
    if not expanded.has(sp.sin, sp.cos):
        return sp.factor_terms(expanded)
    folded = sp.expand(sp.trigsimp(expanded))
    sums = sp.expand(sp.fu(folded)) if folded.count_ops() < 200 else folded
    candidates = [expanded, folded, sums, sp.factor_terms(folded), sp.factor_terms(sums)]
    return min(candidates, key=lambda e: (e.count_ops(), sp.default_sort_key(e)))


def textbook_coefficients(robot: Robot) -> LagrangeCoefficients:
    """B, C, D simplified. Robots with the same rigid arm share them: a diagnosis prints many of one arm."""
    massive = tuple(
        e for e in robot.effects if effect(e.type).body(effect_values(effect(e.type), e.values)) is not None
    )
    return _simplified(replace(robot, effects=massive, parameters=(), channels=None, text="", where=None))


@lru_cache(maxsize=4)
def _simplified(robot: Robot) -> LagrangeCoefficients:
    return lagrange_coefficients(robot).simplified()


def lagrange_coefficients(robot: Robot) -> LagrangeCoefficients:
    """B, C, D of the rigid arm, as derived (not simplified)."""
    axes = joint_coordinates(robot)
    q = [c.q for c in axes]
    n = len(q)
    gravity = sp.Matrix([*(expression(entry) for entry in robot.gravity), 0])
    transforms = base_transforms(robot)
    links = bodies(robot)
    first = [[sp.diff(t, q[j]) if j <= p else sp.zeros(4) for j in range(n)] for p, t in enumerate(transforms)]

    def trace(left: sp.Matrix, p: int, right: sp.Matrix) -> sp.Expr:
        return (left * links[p].pseudo_inertia * right.T).trace()

    inertia = sp.zeros(n)
    centrifugal = [sp.zeros(n) for _ in range(n)]
    weight = [sp.Integer(0)] * n
    for p in range(n):
        if links[p].massless:
            continue
        point = links[p].first_moment.col_join(sp.Matrix([links[p].mass]))
        for i in range(p + 1):
            weight[i] -= (gravity.T * first[p][i] * point)[0]
            for j in range(i, p + 1):
                inertia[i, j] += trace(first[p][j], p, first[p][i])
        for j in range(p + 1):
            for k in range(j, p + 1):
                second = sp.diff(first[p][j], q[k])
                for i in range(p + 1):
                    centrifugal[i][j, k] += trace(second, p, first[p][i])
    for i in range(n):
        for j in range(i):
            inertia[i, j] = inertia[j, i]
            for m in centrifugal:
                m[i, j] = m[j, i]
    return LagrangeCoefficients(axes, inertia, tuple(centrifugal), tuple(weight))
