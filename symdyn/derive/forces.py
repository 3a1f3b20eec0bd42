"""Generalised forces of effects, by two routes: force balance at each port, and Lagrange on totals.

Both start from the same declarations; a slip in either route shows as a difference (tested).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from symdyn.base.nonsmooth import absorb
from symdyn.derive.coordinates import Coordinate
from symdyn.derive.ports import Attachment
from symdyn.physics.effect import PORT


@dataclass(frozen=True, slots=True)
class Contribution:
    """What one effect adds to the equations.

    ``inertial`` (n,) is the force its own mass needs (left-hand side), ``applied`` (n,) the force it
    exerts along each coordinate (right-hand side), ``actuation`` (n,) that of its hidden states and input.
    """

    attachment: Attachment
    inertial: tuple[sp.Expr, ...]
    applied: tuple[sp.Expr, ...]
    actuation: tuple[sp.Expr, ...]

    def depends_on(self, load: sp.Symbol) -> bool:
        """Whether the force depends on the load of a joint, which follows from accelerations."""
        return any(sp.sympify(force).has(load) for force in self.applied)


def balance(item: Attachment, axes: Sequence[Coordinate]) -> Contribution:
    """Newton's way: the force along the port, spread over the coordinates by virtual work."""
    effect, values, port = item.effect, item.values, item.port
    along = port.located(sp.expand(force_along_port(item)))
    momentum = port.located(sp.diff(effect.kinetic_energy(PORT, values), PORT.v))
    inertia_force = _time_derivative(momentum, axes)
    driven = port.located(effect.state_force(PORT, values, item.states, item.control))
    lever = [sp.diff(item.port.v, c.qd) for c in axes]
    return Contribution(
        item,
        tuple(arm * inertia_force for arm in lever),
        tuple(absorb(arm * along) for arm in lever),
        tuple(arm * driven for arm in lever),
    )


def force_along_port(item: Attachment) -> sp.Expr:
    """The effect's law as a force along its port, in the port's own displacement and velocity."""
    effect, values = item.effect, item.values
    return effect.force(PORT, values) + effect.conservative(values) + effect.damping(values)


def lagrange(items: Sequence[Attachment], axes: Sequence[Coordinate]) -> tuple[sp.Expr, ...]:
    """Extended Lagrange (seed eq. 10): d/dt dK/dqd - dK/dq + dU/dq + dW/dqd - Q, per coordinate, of the totals."""
    kinetic, potential, dissipated = totals(items)
    left = []
    for c in axes:
        momentum = sp.diff(kinetic, c.qd)
        terms = _time_derivative(momentum, axes) - sp.diff(kinetic, c.q) + sp.diff(potential, c.q)
        work = sum((sp.diff(i.port.v, c.qd) * i.effect.force(i.port, i.values) for i in items), sp.Integer(0))
        left.append(absorb(terms + sp.diff(dissipated, c.qd) - work))
    return tuple(left)


def totals(items: Sequence[Attachment]) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Kinetic energy K, potential energy U and Rayleigh function W of the effects (seed eq. 11-13)."""
    kinetic = sum((i.effect.kinetic_energy(i.port, i.values) for i in items), sp.Integer(0))
    potential = sum((i.effect.potential_energy(i.port, i.values) for i in items), sp.Integer(0))
    dissipated = sum((i.effect.dissipation(i.port, i.values) for i in items), sp.Integer(0))
    return kinetic, potential, dissipated


def _time_derivative(momentum: sp.Expr, axes: Sequence[Coordinate]) -> sp.Expr:
    return sum(
        (sp.diff(momentum, c.qd) * c.qdd + sp.diff(momentum, c.q) * c.qd for c in axes),
        sp.Integer(0),
    )
