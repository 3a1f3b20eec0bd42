"""Channels of the other sign than the model's, or taken for one another: a recording's fault, asked before physics."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from symdyn.base.errors import BadRecording, Problem
from symdyn.numeric.explanation import Case, Explanation
from symdyn.numeric.fitting import relative_error
from symdyn.numeric.recording import ChannelKey, Recording
from symdyn.numeric.setting import Setting
from symdyn.spec.records import Quantity

Array = NDArray[np.float64]
Channels = Mapping[ChannelKey, Array]

POOR = 0.1  # held-out error of the model as given, from which on it is asked
HOPEFUL = 0.8  # times the error at the parameters as given: what does no better there is not fitted
CURES = 0.3  # times the held-out error of the fit: physics that is missing is not cured by a sign
DRIVING = (Quantity.EFFORT, Quantity.CURRENT, Quantity.VOLTAGE)


@dataclass(frozen=True, slots=True)
class _Mistake:
    what: str
    mend: str
    put_right: Callable[[Channels], Channels]


def check_confused(setting: Setting, case: Case, given: Explanation) -> None:
    """Raise BadRecording (SD533) where one sign, or one exchange of two efforts, leaves less than a third.

    Missing friction, springs or masses never do: the model's parameters were fitted either way. Where a mistake is
    the same as another motion of the same machine (a pendulum's angle and torque both) it does no harm.
    """
    error = case.errors(given).heldout
    if error < POOR or not np.any(case.bench.effort):
        return
    edge, start = case.bench.edge, case.bench.kernel.values
    usual = relative_error(case.bench.residual(start), case.bench.reference)
    trials = []
    for mistake in _mistakes(setting):
        other = _put_right(setting, mistake)
        bench = other.training_laws(edge).bench
        trials.append((relative_error(bench.residual(start), bench.reference), mistake.what, mistake, other))
    best, _, mistake, other = min(trials, key=lambda trial: trial[:2])
    if best > HOPEFUL * usual:
        return
    mended = other.case(edge)
    left = mended.errors(mended.explain()).heldout
    if left < CURES * error:
        message = f"{mistake.what}: otherwise the model would leave {100 * left:.2g} % in place of {100 * error:.2g} %"
        raise BadRecording(Problem("SD533", message, hint=mistake.mend))


def _mistakes(setting: Setting) -> Iterator[_Mistake]:
    driven = [joint.name for joint in setting.robot.joints if not joint.passive]
    for joint in setting.joints:
        told = f"the position of '{joint}' has the other sign than the model's"
        mend = "write sign = -1 for its column (and that of its velocity), or turn the axis of the joint in the model"
        yield _Mistake(told, mend, _turned(joint, (Quantity.POSITION,)))
    for joint in driven:
        told = f"the effort of '{joint}' has the other sign than the model's"
        yield _Mistake(told, "write sign = -1 for its column", _turned(joint, DRIVING))
    for one, other in combinations(driven, 2):
        told = f"the efforts of '{one}' and '{other}' were taken for one another"
        yield _Mistake(told, "exchange their columns in the channel map", _exchanged(one, other))


def _turned(joint: str, quantities: tuple[Quantity, ...]) -> Callable[[Channels], Channels]:
    return lambda channels: {
        key: -values if key[0] in quantities and key[1] == joint else values for key, values in channels.items()
    }


def _exchanged(one: str, other: str) -> Callable[[Channels], Channels]:
    names = {one: other, other: one}
    return lambda channels: {
        (key[0], names.get(key[1], key[1]), key[2]) if key[0] in DRIVING else key: values
        for key, values in channels.items()
    }


def _put_right(setting: Setting, mistake: _Mistake) -> Setting:
    def mended(recording: Recording) -> Recording:
        return replace(recording, channels=MappingProxyType(dict(mistake.put_right(recording.channels))))

    return replace(setting, training=mended(setting.training), heldout=mended(setting.heldout), _shown={}, _forces={})
