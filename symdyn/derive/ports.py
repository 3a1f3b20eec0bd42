"""Where each effect of a robot acts, in its coordinates: drive elements and declared effects alike."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import sympy as sp

from symdyn.base import symbols
from symdyn.derive.coordinates import Coordinate, coordinates
from symdyn.derive.quantities import expression
from symdyn.physics import effect as find_effect
from symdyn.physics.effect import Effect, Port, Values
from symdyn.spec.records import JOINT_END, Drive, Monomial, Robot


@dataclass(frozen=True, slots=True)
class Attachment:
    """One effect at one place. ``port`` is in generalised coordinates and velocities."""

    effect: Effect
    address: str
    port: Port
    values: Values
    control: sp.Symbol | None = None
    state: sp.Symbol | None = None

    @property
    def origin(self) -> str:
        return f"{self.effect.title} at {self.address}"


def ports(robot: Robot) -> Mapping[str, Port]:
    """The port of every place: joints, rotors, shafts (twist = end minus start)."""
    free = {c.address: c for c in coordinates(robot)}
    found: dict[str, Port] = {}
    for joint in robot.joints:
        found[joint.name] = _port(free[joint.name])
        if joint.drive is None:
            continue
        ratio = expression(joint.drive.ratio)
        output = Port(ratio * found[joint.name].x, ratio * found[joint.name].v)
        ends = {JOINT_END: output}
        found[f"{joint.name}.{JOINT_END}"] = output
        for rotor in joint.drive.rotors:
            address = f"{joint.name}.{rotor.name}"
            ends[rotor.name] = found[address] = output if rotor.fixed_to_joint else _port(free[address])
        for shaft in joint.drive.shafts:
            start, end = ends[shaft.start], ends[shaft.end]
            found[f"{joint.name}.{shaft.name}"] = Port(end.x - start.x, end.v - start.v)
    return found


def attachments(robot: Robot) -> tuple[Attachment, ...]:
    """Every effect of the robot, those that its drive records stand for first; inputs and states numbered.

    Raises KeyError only for an effect that the catalogue lacks, which a reader has refused before.
    """
    at = ports(robot)
    found, states = [], 0
    controls = {joint.name: symbols.control(i) for i, joint in enumerate(robot.joints, start=1)}
    for identifier, address, values in _declared(robot):
        item = find_effect(identifier)
        state = None
        if item.hidden_state() is not None:
            states += 1
            state = symbols.hidden(states)
        control = controls[address.partition(".")[0]] if item.input_unit() is not None else None
        named = {p.name: symbols.number(p.default) for p in item.parameters if p.default is not None}
        named |= {name: expression(value) for name, value in values}
        found.append(Attachment(item, address, at[address], named, control, state))
    return _through_transmissions(found)


def _port(coordinate: Coordinate) -> Port:
    return Port(coordinate.q, coordinate.qd)


def _declared(robot: Robot) -> Iterator[tuple[str, str, tuple[tuple[str, Monomial], ...]]]:
    for joint in robot.joints:
        if joint.drive is not None:
            yield from _drive_effects(joint.name, joint.drive)
    for declared in robot.effects:
        yield declared.type, declared.at, declared.values


def _drive_effects(joint: str, drive: Drive) -> Iterator[tuple[str, str, tuple[tuple[str, Monomial], ...]]]:
    """A drive train is sugar for effects at its places; the physics stands in their files alone."""
    for rotor in drive.rotors:
        yield "added_inertia", f"{joint}.{rotor.name}", (("inertia", rotor.inertia),)
    for shaft in drive.shafts:
        yield "linear_spring", f"{joint}.{shaft.name}", (("stiffness", shaft.stiffness),)
        yield "viscous_friction", f"{joint}.{shaft.name}", (("coefficient", shaft.damping),)
    if drive.motor is not None:
        motor = drive.motor
        yield (
            "dc_motor",
            f"{joint}.{motor.at}",
            (
                ("resistance", motor.resistance),
                ("inductance", motor.inductance),
                ("torque_constant", motor.torque_constant),
                ("back_emf_constant", motor.back_emf_constant),
            ),
        )


def _through_transmissions(found: list[Attachment]) -> tuple[Attachment, ...]:
    """Springs and dampers at a place with a transmission (backlash) feel what it lets through."""
    changed: dict[str, Port] = {}
    for item in found:
        before = changed.get(item.address, item.port)
        after = item.effect.transmission(before, item.values)
        if after is not None:
            changed[item.address] = after
    return tuple(
        Attachment(i.effect, i.address, changed.get(i.address, i.port), i.values, i.control, i.state)
        for i in found
        if i.effect.transmission(i.port, i.values) is None
    )
