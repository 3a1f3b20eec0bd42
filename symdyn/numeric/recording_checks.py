"""What can be wrong with the channels of a recording: units and signs, idle ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from symdyn.base.errors import Problem, Where
from symdyn.numeric.recording_time import Samples, Segments
from symdyn.spec.records import Channel, Quantity, Side

_WINDOW = 16  # samples over which a change of position is held against the integral of velocity
MANY_TURNS = 4.0 * math.pi  # rad: angles that go further may be in degrees
_KNOWN_RATIOS = (
    (180 / math.pi, "the position is in degrees where the velocity is in rad/s"),
    (math.pi / 180, "the velocity is in deg/s where the position is in rad"),
    (math.pi / 30, "the velocity is in rev/min"),
    (2 * math.pi, "the velocity is in rev/s"),
    (1e3, "the position is in mm where the velocity is in m/s"),
    (1e-3, "the time is in ms, or the velocity in mm/s"),
    (1e-6, "the time is in us"),
    (1e-9, "the time is in ns"),
)


def check_channels(
    time: Samples, segments: Segments, measured: Sequence[tuple[Channel, Samples]], places: Mapping[Channel, Where]
) -> tuple[list[Problem], list[Problem]]:
    """Errors and warnings on units (SD506), velocity against position (SD507), idle channels (SD508)."""
    errors: list[Problem] = []
    warnings: list[Problem] = []
    positions = {(c.joint, c.side): (c, values) for c, values in measured if c.quantity is Quantity.POSITION}
    for channel, values in measured:
        where = places[channel]
        if np.ptp(values) == 0.0:
            message = f"channel '{channel.column}' is constant ({values[0]:.6g}): it tells nothing"
            warnings.append(Problem("SD508", message, where))
        elif channel.quantity is Quantity.POSITION and channel.unit == "rad" and not _behind_a_gear(channel):
            warnings += _suspect_degrees(channel, values, where)
        if channel.quantity is Quantity.VELOCITY and (channel.joint, channel.side) in positions:
            reference, position = positions[channel.joint, channel.side]
            found, blatant = _compare(_movement(time, segments, position, values), channel, reference, where)
            (errors if blatant else warnings).extend(found)
    return errors, warnings


def _behind_a_gear(channel: Channel) -> bool:
    """Whether it shows a part of a drive, which turns many times with its joint."""
    return channel.side is Side.MOTOR or "." in channel.joint


def _suspect_degrees(channel: Channel, values: Samples, where: Where) -> list[Problem]:
    largest = float(np.max(np.abs(values)))
    if largest <= MANY_TURNS:
        return []
    message = f"'{channel.column}' reaches {largest:.4g} rad, more than two turns"
    return [Problem("SD506", message, where, 'if the column is in degrees, write unit = "deg"')]


def _compare(
    movement: tuple[Samples, Samples], channel: Channel, reference: Channel, where: Where
) -> tuple[list[Problem], bool]:
    """SD507 when a velocity is not the derivative of the position; the flag says that this is beyond doubt."""
    increments, integrals = movement
    moved = math.sqrt(float(increments @ increments) * float(integrals @ integrals))
    if moved == 0.0:
        return [], False
    correlation = float(increments @ integrals) / moved
    names = f"velocity '{channel.column}' is not the derivative of position '{reference.column}'"
    if abs(correlation) <= 0.9:
        message = f"{names}: their correlation is {correlation:.2f}"
        return [Problem("SD507", message, where, "check what the two columns hold")], False
    # of the two norms, not of a regression: noise in either signal biases it little
    size = math.sqrt(float(increments @ increments) / float(integrals @ integrals))
    if correlation > 0 and 0.8 <= size <= 1.25:
        return [], False
    ratio = math.copysign(size, correlation)
    message = f"{names}: the derivative is {ratio:.4g} times the velocity (correlation {correlation:.3f})"
    fixes = []
    if ratio < 0:
        fixes.append(f"sign = {-channel.sign}")
    if not 0.8 <= size <= 1.25:
        fixes.append(f"scale = {channel.scale * size:.6g}")
        message += next((f"; maybe {text}" for known, text in _KNOWN_RATIOS if abs(size / known - 1) < 0.1), "")
    hint = f"for '{channel.column}' write {' and '.join(fixes)}; or correct '{reference.column}' or the unit of time"
    return [Problem("SD507", message, where, hint)], True


def _movement(time: Samples, segments: Segments, position: Samples, velocity: Samples) -> tuple[Samples, Samples]:
    """Changes of position, and integrals of velocity, over windows within the segments.

    Against windows, so that no noisy signal is differentiated.
    """
    changes, integrals = [np.zeros(0)], [np.zeros(0)]
    for part in segments:
        v, step = velocity[part], np.diff(time[part])
        window = min(_WINDOW, len(step))
        if window:
            path = np.concatenate(([0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * step)))
            changes.append(position[part][window:] - position[part][:-window])
            integrals.append(path[window:] - path[:-window])
    return np.concatenate(changes), np.concatenate(integrals)
