"""Where physics could be missing: each equation and each coupling of a model, as directions of an unknown force."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symdyn.emit.kernel import Kernel
from symdyn.numeric.candidates import Candidate
from symdyn.numeric.gearing import gear_ratio, shaft_end
from symdyn.physics import catalogue
from symdyn.spec.places import joint_places
from symdyn.spec.records import Drive, Joint, Place, PlaceKind, Robot

Array = NDArray[np.float64]

_PUSHES = {PlaceKind.JOINT: "force_offset", PlaceKind.INERTIA: "force_offset", PlaceKind.CIRCUIT: "amplifier_offset"}


@dataclass(frozen=True, slots=True, eq=False)
class Latent:
    """An unknown force at a place: ``direction`` (np,) in the space of parameters, whose offset it moves.

    ``motion`` (n,): the displacement that it works along, in terms of the coordinates; zero in a circuit.
    """

    place: str
    direction: Array
    motion: Array


def latent_at(latents: Iterable[Latent], address: str) -> Latent | None:
    """The one at a place; None where there is none, as at a rotor that turns with its joint."""
    return next((latent for latent in latents if latent.place == address), None)


def is_push(candidate: Candidate) -> bool:
    """Whether the candidate is what unknown forces move."""
    return candidate.effect == _PUSHES.get(candidate.place.kind)


def push_at(place: Place) -> str:
    """The name of the parameter that an unknown force at a place moves, where it is proposed there."""
    effect = catalogue()[_PUSHES[place.kind]]
    (size,) = effect.parameters
    return Candidate(effect.identifier, effect.title, place, (size,), (), effect.builds_on).parameter(size)


def latents(robot: Robot, kernel: Kernel, proposed: tuple[Candidate, ...]) -> tuple[Latent, ...]:
    """One for every equation (coordinate, circuit) and every coupling, equal and opposite on its two sides."""
    coordinates = {address: i for i, address in enumerate(kernel.coordinates)}
    pushes = {c.place.address: c.parameter(c.linear[0]) for c in proposed if is_push(c)}
    index = {name: i for i, name in enumerate(kernel.parameters)}
    found = []
    for joint in robot.joints:
        for place in joint_places(joint):
            direction = np.zeros(len(kernel.parameters))
            if place.kind is PlaceKind.SHAFT:
                assert joint.drive is not None
                _couple(joint, joint.drive, gear_ratio(robot, joint), place.address, pushes, index, direction)
            elif place.address in pushes:
                direction[index[pushes[place.address]]] = 1.0
            if direction.any():
                motion = np.zeros(len(coordinates))
                for address, name in pushes.items():
                    if address in coordinates:
                        motion[coordinates[address]] = direction[index[name]]
                found.append(Latent(place.address, direction, motion))
    return tuple(found)


def _couple(
    joint: Joint,
    drive: Drive,
    ratio: float,
    address: str,
    pushes: Mapping[str, str],
    index: Mapping[str, int],
    out: Array,
) -> None:
    shaft = next(s for s in drive.shafts if address == f"{joint.name}.{s.name}")
    for end, sign in ((shaft.start, -1.0), (shaft.end, 1.0)):
        at = shaft_end(joint, end)
        if at in pushes:
            out[index[pushes[at]]] += sign * (ratio if at == joint.name else 1.0)
