"""Reads a [recording] table: which column of a recording measures what, in which unit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from symdyn.base.units import UnitError, si_factor
from symdyn.base.wording import did_you_mean, quoted
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.field_units import channel_unit, motion_of
from symdyn.spec.findings import Findings
from symdyn.spec.places import joint_places
from symdyn.spec.records import Channel, ChannelMap, Joint, Motion, Parameter, Quantity, Robot, Side
from symdyn.spec.references import reference_units
from symdyn.spec.schema import ChannelMapFile, ChannelTable, RecordingTable
from symdyn.spec.shape import validated
from symdyn.spec.toml_positions import KeyPath
from symdyn.spec.toml_source import parse, read_text


def read_channel_map(path: str | Path, robot: Robot, catalogue: Mapping[str, EffectSchema]) -> ChannelMap:
    """The channel map in a TOML file of its own, for a robot. InputError with all that is wrong."""
    source = parse(read_text(path), str(path))
    findings = Findings(source)
    shape = validated(ChannelMapFile, source.data, findings)
    channels = None
    if shape is not None:
        references = reference_units(robot.joints, robot.effects, catalogue)
        channels = read_channels(shape.recording, robot.joints, robot.parameters, references, findings)
    findings.raise_errors()
    assert channels is not None  # without a shape there are errors
    return channels


def read_channels(
    table: RecordingTable,
    joints: Sequence[Joint],
    parameters: Sequence[Parameter],
    references: Mapping[str, str],
    findings: Findings,
) -> ChannelMap:
    """The channel map of a [recording] table; what is wrong is added to the findings.

    ``references`` are the units of what servo loops follow (``reference_units``).
    """
    path: KeyPath = ("recording",)
    motions = {joint.name: motion_of(joint.kind) for joint in joints}
    motions |= {place.address: place.motion for joint in joints for place in joint_places(joint)}
    drives = {joint.name: Motion.ROTATIONAL for joint in joints if joint.drive is not None}  # whatever the joint does
    by_side = {Side.LINK: motions, Side.MOTOR: motions | drives, Side.OUTPUT: {j.name: motions[j.name] for j in joints}}
    time_factor = _factor(table.time.unit, "s", (*path, "time", "unit"), findings)
    units = {parameter.name: parameter.unit for parameter in parameters}
    channels = tuple(
        _read_parameter(channel, (*path, "channel", i), units, findings)
        if channel.quantity == Quantity.PARAMETER
        else _read_channel(channel, (*path, "channel", i), by_side, references, findings)
        for i, channel in enumerate(table.channel)
    )
    channels = tuple(_at_one_of(c, drives) if c.side is Side.OUTPUT else c for c in channels)
    _check_columns(table, findings)
    _check_measured_once(channels, findings)
    return ChannelMap(table.time.column, time_factor, channels, findings.where(path), table.time.unit)


def _at_one_of(channel: Channel, drives: Mapping[str, Motion]) -> Channel:
    """Without a drive its output is the joint itself."""
    return channel if channel.joint in drives else replace(channel, side=Side.LINK)


def _read_channel(
    table: ChannelTable,
    path: KeyPath,
    motions: Mapping[Side, Mapping[str, Motion]],
    references: Mapping[str, str],
    findings: Findings,
) -> Channel:
    quantity, side = Quantity(table.quantity), Side(table.side)
    factor = 1.0
    if table.parameter:
        findings.error((*path, "parameter"), "SD203", f"a {quantity} is that of a joint, not of a parameter")
    if not table.joint:
        findings.error(path, "SD202", f"`joint`: missing; a {quantity} is measured at a joint, or a part of a drive")
        return _channel(table, "", factor, path, findings)
    motion = motions[side].get(table.joint)
    if motion is None:
        advice = did_you_mean(table.joint, motions[side], "joints and parts of drives")
        findings.error((*path, "joint"), "SD104", f"no joint {quoted(table.joint)}", advice)
    elif quantity is Quantity.REFERENCE:
        factor = _of_loop(table, path, references, findings)
    else:
        moves = Motion.ROTATIONAL if motion is Motion.ELECTRICAL else motion
        factor = _factor(table.unit, channel_unit(quantity, moves), (*path, "unit"), findings)
    if table.scale == 0:
        findings.error((*path, "scale"), "SD203", "a scale of 0 makes every sample zero")
    if side is Side.OUTPUT and quantity not in (Quantity.EFFORT, Quantity.REFERENCE):
        hint = 'what moves there is the joint itself: side = "link"'
        findings.error((*path, "side"), "SD203", f"at a drive's output an effort is measured, and no {quantity}", hint)
    return _channel(table, table.joint, factor, path, findings)


def _of_loop(table: ChannelTable, path: KeyPath, references: Mapping[str, str], findings: Findings) -> float:
    """Factor from the unit of a reference to that of its loop."""
    unit = references.get(table.joint)
    if unit is None:
        message = f"no servo loop at {quoted(table.joint)} follows a reference"
        hint = "declare the loop as an [[effect]]: position_servo at the motor, say; or map what drives the motor"
        findings.error((*path, "quantity"), "SD203", message, hint)
        return 1.0
    if Side(table.side) is not Side.LINK:
        message = "a reference has no side: it is what the loop compares with what it measures at its own place"
        findings.error((*path, "side"), "SD203", message, "leave `side` out")
    return _factor(table.unit, unit, (*path, "unit"), findings)


def _read_parameter(table: ChannelTable, path: KeyPath, units: Mapping[str, str], findings: Findings) -> Channel:
    """A parameter whose value is known in every sample."""
    if table.joint:
        findings.error((*path, "joint"), "SD203", "a known parameter is named by `parameter`, and has no joint")
    if table.parameter not in units:
        advice = did_you_mean(table.parameter, units, "parameters")
        findings.error(
            (*path, "parameter") if table.parameter else path,
            "SD104",
            f"no parameter {quoted(table.parameter)}",
            advice,
        )
        return _channel(table, table.parameter, 1.0, path, findings)
    factor = _factor(table.unit, units[table.parameter], (*path, "unit"), findings)
    return _channel(table, table.parameter, factor, path, findings)


def _channel(table: ChannelTable, of: str, factor: float, path: KeyPath, findings: Findings) -> Channel:
    return Channel(
        table.column,
        Quantity(table.quantity),
        of,
        Side(table.side),
        table.unit,
        factor,
        table.scale,
        table.sign,
        findings.where(path),
    )


def _factor(unit: str, expected: str, path: KeyPath, findings: Findings) -> float:
    try:
        factor = si_factor(unit, expected)
    except UnitError as error:
        findings.error(path, error.code, error.message, error.hint)
        return 1.0
    if not (math.isfinite(factor) and factor > 0):
        findings.error(path, "SD201", f"unit {quoted(unit)} is out of range")
        return 1.0
    return factor


def _check_columns(table: RecordingTable, findings: Findings) -> None:
    first: dict[str, KeyPath] = {table.time.column: ("recording", "time", "column")}
    for i, channel in enumerate(table.channel):
        path = ("recording", "channel", i, "column")
        other = first.setdefault(channel.column, path)
        if other != path:
            findings.error(
                path, "SD106", f"column {quoted(channel.column)} is used twice, first at {findings.where(other)}"
            )


def _check_measured_once(channels: Sequence[Channel], findings: Findings) -> None:
    first: dict[tuple[Quantity, str, Side], int] = {}
    for i, channel in enumerate(channels):
        other = first.setdefault((channel.quantity, channel.joint, channel.side), i)
        if other != i:
            where = findings.where(("recording", "channel", other))
            what = f"{channel.quantity} of {quoted(channel.joint)} ({channel.side} side)"
            findings.error(("recording", "channel", i), "SD106", f"{what} is measured twice, first at {where}")
