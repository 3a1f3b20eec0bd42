"""A tachometer that lags: what its channel shows of it, and the machine with that state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from symdyn.numeric.filtering.beliefs import untold
from symdyn.numeric.filtering.explain import remembered
from symdyn.numeric.filtering.judged import Explanation, explained
from symdyn.numeric.filtering.likelihood import fit
from symdyn.numeric.filtering.model import Lagging, Model, carried, prepare
from symdyn.numeric.filtering.score import Left
from symdyn.numeric.gearing import TACHOMETER
from symdyn.numeric.recording import Recording
from symdyn.physics import catalogue
from symdyn.spec.records import EffectSpec, Monomial, Parameter

Array = NDArray[np.float64]

LAG = "time_constant"
FEWEST = 0.05  # of a step: a lag below is none


@dataclass(frozen=True, slots=True)
class Late:
    """A sensor whose channel trails: gain in nats, first estimate of its lag in s."""

    sensor: EffectSpec
    gain: float
    lag: float


def late_sensors(model: Model, current: Explanation) -> tuple[Late, ...]:
    """Score tests of a lag at every tachometer without one, best first: its innovations follow its rate of change."""
    bench, p = current.fit.bench, current.fit.p
    done = bench.filtered(p)
    left = Left.of(bench, p, tuple(current.beliefs))
    shown = bench.signals.y - done.innovations
    names = bench.signals.names
    found = []
    for sensor in model.robot.effects:
        channel = f"{sensor.at}.voltage"
        given = dict(sensor.values).get(LAG)
        if sensor.type != TACHOMETER or (given is not None and not given.is_zero) or channel not in names:
            continue
        c = names.index(channel)
        column = np.zeros_like(bench.signals.y)
        steps = np.where(np.isnan(bench.signals.steps), np.inf, bench.signals.steps)
        rate = np.diff(shown[:, c], append=shown[-1:, c]) / steps
        column[:, c] = -rate / np.sqrt(done.variances[:, c])
        gain, lag, _ = left.explained(column.reshape(-1, 1), np.zeros(1), np.array([np.inf]))
        found.append(Late(sensor, gain, max(float(lag[0]), FEWEST * float(np.nanmedian(bench.signals.steps)))))
    return tuple(sorted(found, key=lambda late: -late.gain))


def with_lag(
    model: Model,
    current: Explanation,
    late: Late,
    recordings: tuple[Recording, Recording],
    progress: Callable[[str], None],
) -> tuple[Model, Explanation]:
    """The machine with that lag, fitted from where it stands without; effects found are kept."""
    progress(f"deriving and compiling {model.robot.name} with a lag of {late.sensor.at}")
    new = Lagging(late.sensor.type, late.sensor.at, LAG, f"{late.sensor.at.replace('.', '_')}_{TACHOMETER}_{LAG}")
    schema = next(s for s in catalogue()[TACHOMETER].parameters if s.name == LAG)
    rest = tuple(item for item in late.sensor.values if item[0] != LAG)
    slow = replace(late.sensor, values=(*rest, (LAG, Monomial(Fraction(1), ((new.parameter, 1),)))))
    robot = replace(
        model.robot,
        effects=tuple(slow if e == late.sensor else e for e in model.robot.effects),
        parameters=(*model.robot.parameters, Parameter(new.parameter, late.lag, "s", schema.latex, schema.meaning)),
    )
    whole = prepare(robot, *recordings, remembered(current))
    whole = replace(whole, beliefs=model.beliefs, freed=model.freed, lagging=(*model.lagging, new))
    p, bench = carried(whole, current.fit.p, current.fit.bench)
    beliefs = dict(current.beliefs)
    beliefs[new.parameter] = untold(late.lag)
    return whole, explained(whole, current.found, beliefs, fit(bench, p, beliefs))
