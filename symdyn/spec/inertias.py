"""Rigid bodies as numbers: mass, centre of mass and inertia, moved to another frame, joined, taken apart."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from symdyn.spec.rotations import Array

_ROUNDING = 1e-13  # of the largest entry; below, a product of turned frames is zero


@dataclass(frozen=True, eq=False)
class Inertial:
    """``mass``, ``com`` (3,), ``tensor`` (3, 3) about the centre of mass, all in one frame."""

    mass: float
    com: Array
    tensor: Array

    def seen_from(self, place: Array) -> Inertial:
        """The body in the frame in which its own is placed by (4, 4)."""
        rotation = place[:3, :3]
        return Inertial(
            self.mass, cleaned(rotation @ self.com + place[:3, 3]), cleaned(rotation @ self.tensor @ rotation.T)
        )

    def about(self, point: Array) -> Array:
        """(3, 3) tensor about a point: Huygens-Steiner."""
        arm = self.com - point
        result: Array = self.tensor + self.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        return result


NOTHING = Inertial(0.0, np.zeros(3), np.zeros((3, 3)))


def joined(bodies: Iterable[Inertial]) -> Inertial:
    """Bodies fixed to each other, as one; those without mass or inertia leave no trace, not even rounding."""
    present = [body for body in bodies if body.mass or body.tensor.any()]
    if len(present) < 2:
        return present[0] if present else NOTHING
    mass = sum(body.mass for body in present)
    moment = sum((body.mass * body.com for body in present), np.zeros(3))
    com = cleaned(moment / mass) if mass else np.zeros(3)
    return Inertial(mass, com, cleaned(sum((body.about(com) for body in present), np.zeros((3, 3)))))


def without(whole: Inertial, part: Inertial) -> Inertial:
    """What is left of a body when a part of it is taken away."""
    if not part.mass and not part.tensor.any():
        return whole
    mass = whole.mass - part.mass
    com = cleaned((whole.mass * whole.com - part.mass * part.com) / mass) if mass else whole.com
    tensor = whole.about(com) - part.about(com)
    return Inertial(mass, com, cleaned(tensor))


def cleaned(array: Array) -> Array:
    """The array with what is only rounding beside its largest entry set to zero."""
    size = float(np.abs(array).max(initial=0.0))
    result: Array = np.where(np.abs(array) < _ROUNDING * size, 0.0, array) + 0.0
    return result
