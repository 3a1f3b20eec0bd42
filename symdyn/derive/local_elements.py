"""What each effect stores and loses for small motions along its own place: inertia, stiffness, damping there."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from symdyn.derive.equations import EquationsOfMotion
from symdyn.derive.forces import force_along_port
from symdyn.physics.effect import PORT


@dataclass(frozen=True, slots=True)
class LocalElement:
    """Second derivatives of an effect's energies along its port; ``lever`` (n,) is d port / d coordinates."""

    address: str
    title: str
    lever: tuple[sp.Expr, ...]
    inertia: sp.Expr
    stiffness: sp.Expr
    damping: sp.Expr


def local_elements(equations: EquationsOfMotion) -> tuple[LocalElement, ...]:
    """One per effect that has any of the three, in the order of the equations."""
    found = []
    for item in equations.attachments:
        effect, values = item.effect, item.values
        along = force_along_port(item)
        inertia = sp.diff(effect.kinetic_energy(PORT, values), PORT.v, 2)
        stiffness, damping = -sp.diff(along, PORT.x), -sp.diff(along, PORT.v)
        if inertia == stiffness == damping == 0:
            continue
        lever = tuple(sp.diff(item.port.v, axis.qd) for axis in equations.axes)
        own = (item.port.located(e) for e in (inertia, stiffness, damping))
        found.append(LocalElement(item.address, effect.title, lever, *own))
    return tuple(found)
