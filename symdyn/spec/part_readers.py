"""Reads the parts of one joint: link, drive train, actuator."""

from __future__ import annotations

from dataclasses import dataclass

from symdyn.base.wording import did_you_mean, quoted
from symdyn.spec.field_units import ACTUATOR_INPUTS, FieldUnit, gain_units, unit_of
from symdyn.spec.numbers import NumberReader, Slot
from symdyn.spec.records import (
    JOINT_END,
    ONE,
    Actuator,
    Drive,
    InertiaAbout,
    Link,
    Monomial,
    Motion,
    Motor,
    Rotor,
    Shaft,
)
from symdyn.spec.schema import ActuatorTable, DriveTable, LinkTable, MotorTable, RotorTable, Scalar, ShaftTable
from symdyn.spec.slots import MOMENTS, com_slots, inertia_slots, mass_slot
from symdyn.spec.toml_positions import KeyPath


@dataclass(frozen=True, slots=True)
class JointContext:
    """What the readers of a joint's parts share."""

    path: KeyPath
    name: str
    motion: Motion
    numbers: NumberReader


def read_link(table: LinkTable, path: KeyPath, owner: str, numbers: NumberReader) -> Link:
    """The body at a key path: that of a link, or of the tool."""
    mass = numbers.read(table.mass, mass_slot(path, owner))
    cx, cy, cz = (numbers.read(value, slot) for value, slot in zip(table.com, com_slots(path, owner), strict=True))
    xx, yy, zz, xy, xz, yz = (
        numbers.read(getattr(table.inertia, entry), slot)
        for entry, slot in zip(MOMENTS, inertia_slots(path, owner), strict=True)
    )
    return Link(mass, (cx, cy, cz), (xx, yy, zz, xy, xz, yz), InertiaAbout(table.inertia.about))


def read_actuator(table: ActuatorTable, joint: JointContext, at_rotor: bool) -> Actuator:
    units = gain_units(Motion.ROTATIONAL if at_rotor else joint.motion)
    slot = Slot(
        (*joint.path, "actuator", "gain"), (joint.name,), "actuator_gain", units[0], "G", f"drive gain of {joint.name}"
    )
    gain, unit = joint.numbers.read_in_one_of(table.gain, slot, units)
    return Actuator(gain, ACTUATOR_INPUTS[units.index(unit)])


def drive_unit(field: FieldUnit) -> str:
    """A drive turns, whatever its joint does: its ratio carries the conversion."""
    return unit_of(field, Motion.ROTATIONAL)


def read_drive(table: DriveTable, joint: JointContext) -> Drive:
    path = (*joint.path, "drive")
    drive = Drive(
        _read_ratio(table.ratio, path, joint),
        tuple(_read_rotor(rotor, (*path, "rotors", i), joint) for i, rotor in enumerate(table.rotors)),
        tuple(_read_shaft(shaft, (*path, "shafts", i), joint) for i, shaft in enumerate(table.shafts)),
        _read_motor(table.motor, (*path, "motor"), joint) if table.motor is not None else None,
        table.effort_at or "",
    )
    if _ends_exist(drive, path, joint):
        _check_connected(drive, path, joint)
        _check_effort(drive, path, joint)
    return drive


def _read_ratio(value: Scalar, path: KeyPath, joint: JointContext) -> Monomial:
    if not isinstance(value, str) and value == 1:
        return ONE
    turns = joint.motion is Motion.ROTATIONAL
    unit, what = ("1", "motor turns per turn") if turns else ("rad/m", "motor angle per metre")
    slot = Slot((*path, "ratio"), (joint.name,), "drive_ratio", unit, "N", f"{what} of {joint.name}")
    return joint.numbers.read(value, slot)


def _read_rotor(table: RotorTable, path: KeyPath, joint: JointContext) -> Rotor:
    inertia = _read_part(table.name, "inertia", table.inertia, drive_unit(FieldUnit.INERTIA), "J", path, joint)
    return Rotor(table.name, inertia, table.fixed_to_joint)


def _read_shaft(table: ShaftTable, path: KeyPath, joint: JointContext) -> Shaft:
    stiffness = _read_part(table.name, "stiffness", table.stiffness, drive_unit(FieldUnit.STIFFNESS), "c", path, joint)
    damping = _read_part(table.name, "damping", table.damping, drive_unit(FieldUnit.DAMPING), "d", path, joint)
    return Shaft(table.name, table.start, table.end, stiffness, damping)


def _read_motor(table: MotorTable, path: KeyPath, joint: JointContext) -> Motor:
    return Motor(
        table.name,
        table.at,
        _read_part(table.name, "resistance", table.resistance, "Ohm", "R", path, joint),
        _read_part(table.name, "inductance", table.inductance, "H", "L", path, joint),
        _read_part(
            table.name,
            "torque_constant",
            table.torque_constant,
            drive_unit(FieldUnit.TORQUE_CONSTANT),
            "K_{T}",
            path,
            joint,
        ),
        _read_part(
            table.name,
            "back_emf_constant",
            table.back_emf_constant,
            drive_unit(FieldUnit.BACK_EMF_CONSTANT),
            "K_{E}",
            path,
            joint,
        ),
    )


def _read_part(
    part: str, key: str, value: Scalar, unit: str, symbol: str, path: KeyPath, joint: JointContext
) -> Monomial:
    meaning = f"{key.replace('_', ' ')} of {joint.name}.{part}"
    return joint.numbers.read(value, Slot((*path, key), (joint.name, part), key, unit, symbol, meaning))


def _ends_exist(drive: Drive, path: KeyPath, joint: JointContext) -> bool:
    """Whether the shafts and the motor hold on to rotors that exist, or to the joint."""
    ends = [*(rotor.name for rotor in drive.rotors), JOINT_END]
    named: list[tuple[KeyPath, str]] = []
    for i, shaft in enumerate(drive.shafts):
        named += [((*path, "shafts", i, "from"), shaft.start), ((*path, "shafts", i, "to"), shaft.end)]
        if shaft.start == shaft.end:
            joint.numbers.findings.error(
                (*path, "shafts", i), "SD111", f"shaft {quoted(shaft.name)} begins and ends at {quoted(shaft.end)}"
            )
    if drive.motor is not None:
        named.append(((*path, "motor", "at"), drive.motor.at))
    if drive.effort_at:
        named.append(((*path, "effort_at"), drive.effort_at))
    unknown = [(end_path, end) for end_path, end in named if end not in ends]
    for end_path, end in unknown:
        hint = did_you_mean(end, ends, "rotors")
        joint.numbers.findings.error(end_path, "SD104", f"no rotor {quoted(end)} in this drive", hint)
    return not unknown


def _check_effort(drive: Drive, path: KeyPath, joint: JointContext) -> None:
    """What the effort acts on turns by itself, and nothing else drives it."""
    if not drive.effort_at:
        return
    told = "", ""
    if drive.motor is not None:
        told = "the motor supplies the effort, where it stands", "leave out `effort_at`, or the motor"
    elif all(rotor.name != drive.effort_at or rotor.fixed_to_joint for rotor in drive.rotors):
        told = (
            f"{quoted(drive.effort_at)} has no coordinate of its own",
            "leave out `effort_at`: it moves with the joint",
        )
    if told[0]:
        joint.numbers.findings.error((*path, "effort_at"), "SD111", *told)


def _check_connected(drive: Drive, path: KeyPath, joint: JointContext) -> None:
    """Every rotor is held to the joint, through shafts or fixed."""
    reached = {JOINT_END, *(rotor.name for rotor in drive.rotors if rotor.fixed_to_joint)}
    while True:
        further = {
            end for shaft in drive.shafts for end in (shaft.start, shaft.end) if reached & {shaft.start, shaft.end}
        } - reached
        if not further:
            break
        reached |= further
    for i, rotor in enumerate(drive.rotors):
        if rotor.name not in reached:
            joint.numbers.findings.error(
                (*path, "rotors", i),
                "SD111",
                f"rotor {quoted(rotor.name)} is not connected to the joint",
                f'add a shaft that leads to "{JOINT_END}", or fixed_to_joint = true',
            )
