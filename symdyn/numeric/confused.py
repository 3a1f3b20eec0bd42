"""Channels of the other sign or unit than the model's, or taken for one another: asked before physics."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import BadRecording, Problem
from symdyn.numeric.explanation import Case, Explanation
from symdyn.numeric.fitting import relative_error
from symdyn.numeric.observation import observe
from symdyn.numeric.recording import ChannelKey, Recording
from symdyn.numeric.recording_checks import MANY_TURNS
from symdyn.numeric.setting import Setting
from symdyn.spec.records import JointKind, Quantity

Array = NDArray[np.float64]
Channels = Mapping[ChannelKey, Array]

POOR = 0.1  # held-out error of the model as given, from which on it is asked
CURES = 0.3  # times the held-out error of the fit: physics that is missing is not cured by a sign
DRIVING = (Quantity.EFFORT, Quantity.CURRENT, Quantity.VOLTAGE)
SLOW, QUICK = 0.02, 1e-4  # s: samples that come later, or sooner, may have their time in another unit
LITTLE = 0.05  # rad: angles that go less far may be in rad where the map says degrees
DEGREE = math.radians(1.0)
TIMES = {1.0: "s", 1e-3: "ms", 1e-6: "us"}


@dataclass(frozen=True, slots=True)
class _Mistake:
    what: str
    mend: str
    put_right: Callable[[Recording], Recording]
    faster: float = 1.0  # times as fast is what was recorded


def check_confused(setting: Setting, case: Case, given: Explanation) -> None:
    """Raise BadRecording where one mistake put right leaves less than a third of what the fitted model leaves.

    SD533: a sign, all signs of a kind, an exchange of two efforts; SD506: the unit of time, or of angles. Missing
    friction, springs or masses never do that: the model's parameters were fitted either way. Where a mistake is the
    same as another motion of the same machine (a pendulum's angle and torque both) it does no harm.
    """
    error = case.errors(given).heldout
    if error < POOR or not np.any(case.bench.effort):
        return
    edge, start = case.bench.edge, case.bench.kernel.values
    usual = relative_error(case.bench.residual(start), case.bench.reference)
    trials = []
    for mistake in _signs(setting):
        other = _put_right(setting, mistake)
        bench = other.training_laws(edge).bench
        trials.append((relative_error(bench.residual(start), bench.reference), mistake.what, mistake, other))
    best, _, mistake, other = min(trials, key=lambda trial: trial[:2])
    if best < usual:
        _refuse_if_cured("SD533", mistake, other, edge, error)
    for mistake in _units(setting):
        _refuse_if_cured("SD506", mistake, _put_right(setting, mistake), edge * mistake.faster, error)


def _refuse_if_cured(code: str, mistake: _Mistake, mended: Setting, edge: float, error: float) -> None:
    case = mended.case(edge)
    left = case.errors(case.explain()).heldout
    if left < CURES * error:
        message = f"{mistake.what}: otherwise the model would leave {100 * left:.2g} % in place of {100 * error:.2g} %"
        raise BadRecording(Problem(code, message, hint=mistake.mend))


def _signs(setting: Setting) -> Iterator[_Mistake]:
    tested = zip(setting.robot.joints, setting.seen.tested, strict=True)
    driven = [joint.name for joint, known in tested if known and not joint.passive]
    turn = "write sign = -1 for its column (and that of its velocity), or turn the axis of the joint in the model"
    for joint in setting.joints:
        told = f"the position of '{joint}' has the other sign than the model's"
        yield _Mistake(told, turn, _turned((Quantity.POSITION,), joint))
    for joint in driven:
        told = f"the effort of '{joint}' has the other sign than the model's"
        yield _Mistake(told, "write sign = -1 for its column", _turned(DRIVING, joint))
    for one, other in combinations(driven, 2):
        told = f"the efforts of '{one}' and '{other}' were taken for one another"
        yield _Mistake(told, "exchange their columns in the channel map", _exchanged(one, other))
    if len(driven) > 1:
        yield _Mistake("all efforts have the other sign", "write sign = -1 for their columns", _turned(DRIVING))


def _units(setting: Setting) -> Iterator[_Mistake]:
    """Those of which the numbers themselves raise a suspicion."""
    step = setting.training.sample_time
    taken = setting.robot.channels.time_factor if setting.robot.channels else 1.0
    for real, unit in TIMES.items():
        factor = real / taken
        if (step > SLOW and factor < 1.0) or (step < QUICK and factor > 1.0):
            told = f"the time is in {unit}, not in {TIMES.get(taken, 'what the channel map says')}"
            yield _Mistake(told, f'write unit = "{unit}" for the time', _timed(factor), 1.0 / factor)
    turning = [joint.name for joint in setting.robot.joints if joint.kind is JointKind.REVOLUTE]
    farthest = max(
        (float(np.max(np.abs(setting.training.channel(Quantity.POSITION, joint)))) for joint in turning), default=0.0
    )
    if farthest > MANY_TURNS:
        yield _Mistake("the angles are in degrees, not in rad", 'write unit = "deg"', _scaled(turning, DEGREE))
    elif 0.0 < farthest < LITTLE:
        yield _Mistake("the angles are in rad, not in degrees", 'write unit = "rad"', _scaled(turning, 1.0 / DEGREE))


def _turned(quantities: tuple[Quantity, ...], joint: str | None = None) -> Callable[[Recording], Recording]:
    """With the other sign: the quantities of a joint, or of all."""
    return _changed(
        lambda channels: {
            key: -values if key[0] in quantities and joint in (None, key[1]) else values
            for key, values in channels.items()
        }
    )


def _exchanged(one: str, other: str) -> Callable[[Recording], Recording]:
    names = {one: other, other: one}
    return _changed(
        lambda channels: {
            (key[0], names.get(key[1], key[1]), key[2]) if key[0] in DRIVING else key: values
            for key, values in channels.items()
        }
    )


def _scaled(joints: list[str], factor: float) -> Callable[[Recording], Recording]:
    return _changed(
        lambda channels: {
            key: factor * values if key[0] is Quantity.POSITION and key[1] in joints else values
            for key, values in channels.items()
        }
    )


def _changed(change: Callable[[Channels], Channels]) -> Callable[[Recording], Recording]:
    return lambda recording: replace(recording, channels=MappingProxyType(dict(change(recording.channels))))


def _timed(factor: float) -> Callable[[Recording], Recording]:
    return lambda shown: replace(shown, time=factor * shown.time, sample_time=factor * shown.sample_time)


def _put_right(setting: Setting, mistake: _Mistake) -> Setting:
    training = mistake.put_right(setting.training)
    seen = setting.seen if mistake.faster == 1.0 else observe(setting.robot, setting.kernel, training)
    heldout = mistake.put_right(setting.heldout)
    return setting.anew(training=training, heldout=heldout, seen=seen)
