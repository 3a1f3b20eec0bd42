"""Where each effect of a robot acts, in its coordinates: drive elements and declared effects alike."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from symdyn.base import symbols
from symdyn.base.errors import InputError, Problem
from symdyn.base.nonsmooth import is_smooth, pushing
from symdyn.derive.coordinates import Coordinate, coordinates
from symdyn.derive.quantities import effect_values, expression
from symdyn.physics import effect as find_effect
from symdyn.physics.effect import PORT, Effect, Port, Values
from symdyn.spec.records import JOINT_END, Drive, Joint, JointKind, Monomial, Motion, Robot

_NO_CURRENT = Port(sp.Integer(0), sp.Integer(0))  # of a circuit, before its motor is known


@dataclass(frozen=True, slots=True)
class Attachment:
    """One effect at one place. ``port`` is in generalised coordinates and velocities.

    ``states`` are its hidden states; ``control`` is what reaches it of the input of its joint.
    """

    effect: Effect
    address: str
    port: Port
    values: Values
    motion: Motion
    control: sp.Expr
    states: tuple[sp.Symbol, ...] = ()

    @property
    def joint(self) -> str:
        return self.address.partition(".")[0]

    @property
    def origin(self) -> str:
        return f"{self.effect.title} at {self.address}"


def ports(robot: Robot) -> Mapping[str, Port]:
    """The port of every mechanical place: joints, rotors, shafts (twist = end minus start)."""
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
            found[f"{joint.name}.{shaft.name}"] = Port(end.x - start.x, end.v - start.v, start=start)
    return found


def attachments(robot: Robot) -> tuple[Attachment, ...]:
    """Every effect of the robot, those that its drive records stand for first; inputs and states numbered.

    Raises InputError: SD109 for a limit of the effort of a joint that is not driven by it, SD454 for a loop around
    a current that follows its voltage at once; and KeyError only for an effect that the catalogue lacks, which a
    reader has refused before.
    """
    at = ports(robot)
    sliding = {joint.name for joint in robot.joints if joint.kind is JointKind.PRISMATIC}
    declared = tuple(_declared(robot))
    motors = {address.partition(".")[0] for name, address, _ in declared if find_effect(name).input_unit() is not None}
    controls = {}
    for i, joint in enumerate(robot.joints, start=1):
        gain = sp.Integer(1) if joint.actuator is None or joint.name in motors else expression(joint.actuator.gain)
        controls[joint.name] = gain * symbols.control(i)
    found, count = [], 0
    for identifier, address, given in declared:
        item = find_effect(identifier)
        values = effect_values(item, given)
        states = tuple(symbols.hidden(count + k) for k, _ in enumerate(item.hidden_states(values), start=1))
        count += len(states)
        motion = Motion.TRANSLATIONAL if address in sliding else Motion.ROTATIONAL
        control = controls[address.partition(".")[0]]
        found.append(Attachment(item, address, at.get(address, _NO_CURRENT), values, motion, control, states))
    found = _through_amplifiers(_in_circuits(_through_transmissions(found), robot))
    _check_stages(found, robot, motors)
    return _loaded(_in_circuits(found, robot), robot)


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


def _through_transmissions(found: list[Attachment]) -> list[Attachment]:
    """Springs and dampers at a place with a transmission (backlash) feel what it lets through.

    What is smooth comes first, as in a gear: the teeth stand wrongly, and then have play.
    """
    changed: dict[str, Port] = {}
    play: dict[str, sp.Expr] = {}
    for item in sorted(found, key=_has_play):
        before = changed.get(item.address, item.port)
        after = item.effect.transmission(before, item.values)
        if after is not None:
            changed[item.address] = after
        clearance = item.effect.play(item.values)
        if clearance is not None:
            play[item.address] = play.get(item.address, sp.Integer(0)) + clearance
    moved = [
        replace(i, port=changed.get(i.address, i.port))
        for i in found
        if i.effect.transmission(i.port, i.values) is None
    ]
    return [
        replace(i, port=_pushed(i.port, moved, i.address, play[i.address])) if i.address in play else i for i in moved
    ]


def _pushed(port: Port, found: Sequence[Attachment], address: str, play: sp.Expr) -> Port:
    """The port of a contact that opens as soon as its springs and dampers together would pull."""
    force = sum(
        (
            port.located(i.effect.conservative(i.values) + i.effect.damping(i.values))
            for i in found
            if i.address == address
        ),
        sp.Integer(0),
    )
    engaged = pushing(force, port.x, play)
    return replace(port, x=port.x * engaged, v=port.v * engaged)


def _has_play(item: Attachment) -> bool:
    through = item.effect.transmission(PORT, item.values)
    return through is not None and not is_smooth(through.x)


def _through_amplifiers(found: list[Attachment]) -> list[Attachment]:
    """Loops and stages between input and motor work on what the one before hands on, in the order of declaration.

    But for what delays a reference, which comes ahead of all.
    """
    handed_on: dict[str, sp.Expr] = {}
    stages: dict[int, Attachment] = {}
    for k, item in sorted(enumerate(found), key=lambda each: each[1].effect.stage >= 0):
        before = handed_on.get(item.joint, item.control)
        after = item.effect.amplified(item.values, item.states, before)
        if after is None:
            after = item.effect.controls(item.port, item.values, item.states, before)
        if after is not None:
            stages[k] = replace(item, control=before)
            handed_on[item.joint] = after
    return [stages.get(k) or replace(i, control=handed_on.get(i.joint, i.control)) for k, i in enumerate(found)]


def _check_stages(found: list[Attachment], robot: Robot, motors: set[str]) -> None:
    """What works on the effort of a joint needs one that comes from an input; a loop must not feed back at once."""
    elsewhere = {joint.name for joint in robot.joints if joint.passive or (joint.drive and joint.drive.effort_at)}
    undriven = motors | elsewhere
    quick = {motor for joint in robot.joints if (motor := _quick_circuit(joint)) is not None}
    followed = [(i.joint, i.effect.reference_unit()) for i in found if i.effect.stage >= 0]
    for i in found:
        where = next((e.where for e in robot.effects if (e.type, e.at) == (i.effect.identifier, i.address)), None)
        if i.effect.stage < 0 and (i.joint, i.effect.reference_unit()) not in followed:
            message = f"{i.effect.identifier} at '{i.address}': no servo loop of this joint follows a position"
            raise InputError(Problem("SD109", message, where, "declare the loop: position_servo at the motor, say"))
        if i.address in quick and i.effect.reference_unit() is not None:
            message = f"{i.effect.identifier} at '{i.address}' is an algebraic loop: the current follows at once"
            raise InputError(Problem("SD454", message, where, "give the motor its inductance"))
        works = i.effect.amplified(i.values, i.states, i.control) is not None
        if works and i.address in undriven:
            message = f"{i.effect.identifier} at '{i.address}': no input is the effort of this joint"
            hint = "where there is a motor, its circuit is the place for the stages of its amplifier"
            raise InputError(Problem("SD109", message, where, hint))


def _quick_circuit(joint: Joint) -> str | None:
    """The circuit of a motor without inductance."""
    if joint.drive is None or joint.drive.motor is None or not joint.drive.motor.inductance.is_zero:
        return None
    return f"{joint.name}.{joint.drive.motor.name}"


def _in_circuits(found: list[Attachment], robot: Robot) -> list[Attachment]:
    """What sits in a motor's circuit feels the motor's current."""
    currents: dict[str, Port] = {}
    for joint in robot.joints:
        if joint.drive is None or joint.drive.motor is None:
            continue
        motor = joint.drive.motor
        for i in found:
            current = i.effect.current(i.port, i.values, i.states, i.control)
            if current is not None and i.address == f"{joint.name}.{motor.at}":
                currents[f"{joint.name}.{motor.name}"] = Port(sp.Integer(0), current)
    return [replace(i, port=currents.get(i.address, i.port)) for i in found]


def _loaded(found: list[Attachment], robot: Robot) -> tuple[Attachment, ...]:
    """Each port with the force of the springs at its place; effects that sit at an end of a shaft go there.

    At a joint with the effort that passes through it, which is named and follows from the equations as a whole.
    """
    load: dict[str, sp.Expr] = {}
    for i in found:
        load[i.address] = load.get(i.address, sp.Integer(0)) + i.port.located(i.effect.conservative(i.values))
    joints = {joint.name for joint in robot.joints}
    load |= {c.address: symbols.load(k) for k, c in enumerate(coordinates(robot), start=1) if c.address in joints}
    return tuple(replace(i, port=replace(i.effect.seat(i.port), load=load[i.address])) for i in found)
