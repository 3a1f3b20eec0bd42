"""Reads a robot from its TOML file: shape, names, numbers, parts, effects, physical sense; all errors at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from symdyn.base.errors import Problem
from symdyn.base.names import collisions, identifier_problem, robot_name_problem
from symdyn.base.wording import quoted
from symdyn.spec.channel_reader import read_channel_map, read_channels
from symdyn.spec.effect_reader import read_effects
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.field_units import motion_of
from symdyn.spec.findings import Findings
from symdyn.spec.frame_reader import convention_of, read_frames
from symdyn.spec.frames import JointFrame
from symdyn.spec.limits_reader import read_limits
from symdyn.spec.numbers import NumberReader
from symdyn.spec.parameters import Parameters
from symdyn.spec.part_readers import JointContext, read_actuator, read_drive, read_link
from symdyn.spec.physical_checks import check_physics
from symdyn.spec.placement_reader import read_placement
from symdyn.spec.places import joint_places
from symdyn.spec.records import JOINT_END, Joint, Monomial, Robot, Tool
from symdyn.spec.references import reference_units
from symdyn.spec.schema import JointTable, RobotFile, RobotTable, ToolTable
from symdyn.spec.shape import validated
from symdyn.spec.slots import gravity_slots
from symdyn.spec.toml_positions import KeyPath
from symdyn.spec.toml_source import parse, read_text

__all__ = ["read_channel_map", "read_robot", "read_robot_text", "read_with_warnings", "text_with_warnings"]

Catalogue = Mapping[str, EffectSchema]


def read_robot(path: str | Path, catalogue: Catalogue) -> Robot:
    """The robot in a TOML file; ``catalogue`` holds the effects it may name. InputError with every problem found."""
    return read_with_warnings(path, catalogue)[0]


def read_robot_text(text: str, file: str, catalogue: Catalogue) -> Robot:
    """The robot in a TOML text; ``file`` is the name that its errors show."""
    return text_with_warnings(text, file, catalogue)[0]


def read_with_warnings(path: str | Path, catalogue: Catalogue) -> tuple[Robot, tuple[Problem, ...]]:
    """As ``read_robot``, with what is allowed but doubtful."""
    return text_with_warnings(read_text(path), str(path), catalogue)


def text_with_warnings(text: str, file: str, catalogue: Catalogue) -> tuple[Robot, tuple[Problem, ...]]:
    """As ``read_robot_text``, with what is allowed but doubtful."""
    text = text.removeprefix("\ufeff")
    source = parse(text, file)
    findings = Findings(source)
    shape = validated(RobotFile, source.data, findings)
    robot = _build(shape, text, catalogue, findings) if shape is not None else None
    if robot is not None:
        check_physics(robot, findings)
    findings.raise_errors()
    assert robot is not None  # without a robot there are errors
    return robot, findings.warnings


def _build(shape: RobotFile, text: str, catalogue: Catalogue, findings: Findings) -> Robot | None:
    """The robot, with zeros where a number was wrong; None where its joints cannot be told."""
    _check_names(shape, findings)
    numbers = NumberReader(Parameters(shape.parameters, findings), findings)
    gravity = _read_gravity(shape.robot, numbers)
    joint_names = tuple(_usable_name(joint.name, i) for i, joint in enumerate(shape.joint))
    base = None
    if shape.base is not None:
        base = read_placement(shape.base.placement, ("base", "placement"), "base", numbers)
    frames = read_frames(shape, joint_names, numbers)
    if frames is None:
        return None
    joints = tuple(
        _read_joint(table, ("joint", i), joint_names[i], frames[i], numbers) for i, table in enumerate(shape.joint)
    )
    tool = _read_tool(shape.tool, numbers) if shape.tool is not None else None
    places = [place for joint in joints for place in joint_places(joint)]
    effects = read_effects(shape.effect, places, catalogue, numbers)
    channels = None
    if shape.recording is not None:
        references = reference_units(joints, effects, catalogue)
        channels = read_channels(shape.recording, joints, numbers.parameters.every, references, findings)
    return Robot(
        shape.robot.name,
        shape.robot.description,
        convention_of(shape),
        gravity,
        joints,
        effects,
        numbers.parameters.every,
        channels,
        text,
        findings.where(("robot",)),
        base,
        tool,
    )


def _read_gravity(table: RobotTable, numbers: NumberReader) -> tuple[Monomial, Monomial, Monomial]:
    x, y, z = (numbers.read(value, slot) for value, slot in zip(table.gravity, gravity_slots(), strict=True))
    return x, y, z


def _read_tool(table: ToolTable, numbers: NumberReader) -> Tool:
    placement = read_placement(table.placement, ("tool", "placement"), "tool", numbers)
    return Tool(placement, read_link(table, ("tool",), "tool", numbers))


def _read_joint(table: JointTable, path: KeyPath, name: str, frame: JointFrame, numbers: NumberReader) -> Joint:
    context = JointContext(path, name, motion_of(frame.kind), numbers)
    effort_at = table.drive.effort_at if table.drive is not None else None
    motor = table.drive.motor if table.drive is not None else None
    if table.passive and not (table.actuator is None and motor is None and effort_at is None):
        message = f"{quoted(table.name)} is passive, but has something that drives it"
        numbers.findings.error(
            (*path, "passive"), "SD111", message, "leave out `passive`, or the motor, actuator or `effort_at`"
        )
    return Joint(
        table.name,
        frame.kind,
        frame.placement,
        read_link(table.link, (*path, "link"), name, numbers),
        read_drive(table.drive, context) if table.drive is not None else None,
        read_actuator(table.actuator, context, effort_at is not None) if table.actuator is not None else None,
        read_limits(table.limits, context) if table.limits is not None else None,
        table.description,
        table.passive,
    )


def _check_names(shape: RobotFile, findings: Findings) -> None:
    problem = robot_name_problem(shape.robot.name)
    if problem is not None:
        findings.error(("robot", "name"), problem.code, problem.message, problem.hint)
    _check_each([(("joint", i, "name"), joint.name) for i, joint in enumerate(shape.joint)], findings)
    for i, joint in enumerate(shape.joint):
        if joint.drive is None:
            continue
        path: KeyPath = ("joint", i, "drive")
        parts = [((*path, "rotors", k, "name"), rotor.name) for k, rotor in enumerate(joint.drive.rotors)]
        parts += [((*path, "shafts", k, "name"), shaft.name) for k, shaft in enumerate(joint.drive.shafts)]
        if joint.drive.motor is not None:
            parts.append(((*path, "motor", "name"), joint.drive.motor.name))
        _check_each(parts, findings, reserved=JOINT_END)


def _check_each(named: Iterable[tuple[KeyPath, str]], findings: Findings, reserved: str = "") -> None:
    """Names that stand side by side: each well formed, no two alike."""
    entries = list(named)
    for path, name in entries:
        problem = identifier_problem(name)
        if problem is not None:
            findings.error(path, problem.code, problem.message, problem.hint)
        elif name == reserved:
            findings.error(path, "SD102", f"{quoted(name)} means the link side of the drive", "choose another name")
    for later, first in collisions(name for _, name in entries):
        (path, name), (first_path, first_name) = entries[later], entries[first]
        there = findings.where(first_path)
        if name == first_name:
            findings.error(path, "SD106", f"name {quoted(name)} is taken, first at {there}")
        else:
            findings.error(
                path, "SD103", f"{quoted(name)} and {quoted(first_name)} ({there}) differ only by upper and lower case"
            )


def _usable_name(name: str, i: int) -> str:
    """For naming literals: the joint's name, or a stand-in where that is malformed."""
    return name if identifier_problem(name) is None else f"joint{i + 1}"
