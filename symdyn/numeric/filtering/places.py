"""Where physics could be missing: each equation and each coupling of a model, as directions of an unknown force."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel
from symdyn.numeric.candidates import Candidate
from symdyn.spec.places import joint_places
from symdyn.spec.records import Drive, Joint, PlaceKind, Robot

Array = NDArray[np.float64]

_PUSHES = {PlaceKind.JOINT: "force_offset", PlaceKind.INERTIA: "force_offset", PlaceKind.CIRCUIT: "amplifier_offset"}


@dataclass(frozen=True, slots=True, eq=False)
class Latent:
    """An unknown force at a place: ``direction`` (np,) in the space of parameters, whose offset it moves."""

    place: str
    direction: Array


def latents(robot: Robot, kernel: Kernel, proposed: tuple[Candidate, ...]) -> tuple[Latent, ...]:
    """One for every equation (coordinate, circuit) and every coupling, equal and opposite on its two sides."""
    pushes = {c.place.address: c.parameter(c.linear[0]) for c in proposed if c.effect == _PUSHES.get(c.place.kind)}
    index = {name: i for i, name in enumerate(kernel.parameters)}
    found = []
    for joint in robot.joints:
        for place in joint_places(joint):
            direction = np.zeros(len(kernel.parameters))
            if place.kind is PlaceKind.SHAFT:
                assert joint.drive is not None
                _couple(joint, joint.drive, place.address, pushes, index, kernel.values, direction)
            elif place.address in pushes:
                direction[index[pushes[place.address]]] = 1.0
            if direction.any():
                found.append(Latent(place.address, direction))
    return tuple(found)


def _couple(
    joint: Joint, drive: Drive, address: str, pushes: Mapping[str, str], index: Mapping[str, int], p: Array, out: Array
) -> None:
    shaft = next(s for s in drive.shafts if address == f"{joint.name}.{s.name}")
    ratio = float(drive.ratio.coefficient)
    for name, power in drive.ratio.factors:
        ratio *= p[index[name]] ** power
    fixed = {rotor.name for rotor in drive.rotors if rotor.fixed_to_joint} | {"joint"}
    for end, sign in ((shaft.start, -1.0), (shaft.end, 1.0)):
        at = joint.name if end in fixed else f"{joint.name}.{end}"
        if at in pushes:
            out[index[pushes[at]]] += sign * (ratio if end in fixed else 1.0)
