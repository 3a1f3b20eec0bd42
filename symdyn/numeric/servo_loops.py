"""Servo loops in a recording: those whose reference drives the machine, and those that it cuts behind them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symdyn.numeric.circuits import current_of, has_voltage
from symdyn.numeric.gearing import joint_name
from symdyn.numeric.recording import Recording
from symdyn.physics import catalogue
from symdyn.physics.loops import continuous, periods
from symdyn.spec.records import EffectSpec, Joint, Quantity, Robot


def as_driven(robot: Robot, recordings: Sequence[Recording]) -> Robot:
    """The robot with those of its servo loops, run without pause, that the references recorded drive.

    What was recorded between a loop and the machine (voltage, current, effort) drives the machine then, and the loop is
    left out.
    """
    cut = {joint.name for joint in robot.joints if any(_cut(robot, joint, each) for each in recordings)}
    kept = tuple(e for e in robot.effects if not (is_loop(e) and joint_name(e.at) in cut))
    return continuous(replace(robot, effects=kept)) if len(kept) < len(robot.effects) or periods(robot) else robot


def loops_left_out(robot: Robot, driven: Robot) -> tuple[str, ...]:
    """What is to be said of loops that were cut, or are taken for continuous."""
    kept = {(e.type, e.at) for e in driven.effects}
    gone = dict.fromkeys(joint_name(e.at) for e in robot.effects if is_loop(e) and (e.type, e.at) not in kept)
    cut = (f"the servo loop of {joint} is not tested: what was recorded behind it drives the machine" for joint in gone)
    sampled = {e.at: period for e, period in periods(robot) if (e.type, e.at) in kept}
    smooth = (
        f"the servo loop at {at} is sampled every {t:.4g} s, and taken for continuous" for at, t in sampled.items()
    )
    return (*cut, *smooth)


def is_loop(effect: EffectSpec) -> bool:
    return catalogue()[effect.type].reference_unit() is not None


def _cut(robot: Robot, joint: Joint, recording: Recording) -> bool:
    """Whether the recording tells what the loop made of its reference, or does not hold the reference."""
    followed = {joint_name(at) for quantity, at, _ in recording.channels if quantity is Quantity.REFERENCE}
    behind = (
        has_voltage(robot, joint, recording)
        or current_of(joint, recording) is not None
        or recording.has(Quantity.EFFORT, joint.name)
    )
    return joint.name not in followed or behind
