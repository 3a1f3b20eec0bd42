"""The generalised coordinates of a robot: per joint its rotors along the chain, then the joint itself."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from symdyn.base import symbols
from symdyn.spec.records import JointKind, Robot


@dataclass(frozen=True, slots=True)
class Coordinate:
    """One generalised coordinate; ``address`` is the place it belongs to (seed fig. 6: phi_1 .. phi_4)."""

    address: str
    joint: str
    rotational: bool
    q: sp.Symbol
    qd: sp.Symbol
    qdd: sp.Symbol

    @property
    def unit(self) -> str:
        return "rad" if self.rotational else "m"

    @property
    def effort_unit(self) -> str:
        return "N m" if self.rotational else "N"


def coordinates(robot: Robot) -> tuple[Coordinate, ...]:
    """Coordinates in chain order; rotors fixed to their joint have none of their own."""
    found: list[Coordinate] = []
    for joint in robot.joints:
        rotational = joint.kind is JointKind.REVOLUTE
        # A drive's rotors turn, whatever the joint does; their ratio carries the conversion.
        places = [
            (f"{joint.name}.{rotor.name}", True)
            for rotor in (joint.drive.rotors if joint.drive else ())
            if not rotor.fixed_to_joint
        ]
        for address, turns in [*places, (joint.name, rotational)]:
            i = len(found) + 1
            found.append(
                Coordinate(
                    address, joint.name, turns, symbols.coordinate(i), symbols.velocity(i), symbols.acceleration(i)
                )
            )
    return tuple(found)


def joint_coordinates(robot: Robot) -> tuple[Coordinate, ...]:
    """The coordinates of the joints alone, in joint order."""
    by_address = {c.address: c for c in coordinates(robot)}
    return tuple(by_address[joint.name] for joint in robot.joints)
