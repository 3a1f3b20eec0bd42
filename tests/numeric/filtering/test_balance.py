"""Where parts that nobody measures are at the start: held on one flank of their gear by their weight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.compiler import robot_from_text
from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.model import Model, prepare, without_latent

from .soft_gear import RATIO, TOML, TRUE, run

ARM = robot_from_text(TOML, "arm.toml")
PLAY = "arm_gear_backlash_clearance"


def prepared(play: float) -> tuple[Model, FilterBench, NDArray[np.float64]]:
    """Model, filter, and the true parameters."""
    training = run(1, play=play)
    model = prepare(ARM, training, training, only=("backlash at arm.gear", "constant force offset at arm"))
    bench = model.bench(model.training, without_latent(model, model.training), between=Between.HELD)
    p = model.values
    for name, value in {**TRUE, PLAY: play}.items():
        p[bench.index[name]] = value
    return model, bench, p


def test_a_weight_holds_the_gear_on_one_flank() -> None:
    model, bench, p = prepared(play=0.5)
    x = bench._balance.found(p[: len(model.kernel.parameters)], bench._start)
    arm, motor = (model.kernel.coordinates.index(name) for name in ("arm", "arm.motor"))
    angle = bench.signals.y[0, 0]
    held = TRUE["m"] * 9.81 * TRUE["r"] * np.cos(angle / RATIO) / RATIO
    twist = x[motor] - RATIO * x[arm]
    # What the motion accelerates bends it, too, by a part of that; and both flanks are where they are.
    assert 0.5 * held < TRUE["k"] * (twist - 0.5) < 2.0 * held
    assert x[motor] == bench._start[motor]


def test_a_filter_that_begins_there_follows_from_the_first_sample() -> None:
    _, bench, p = prepared(play=0.5)
    moment = slice(0, round(0.8 / bench.signals.steps[0]))
    innovations = bench.filtered(p).innovations[moment, 0]
    unbent = FilterBench(bench.kernel, bench.signals, bench.noise, between=Between.HELD, delays=bench.delays)
    unbent._balance = replace(bench._balance, hidden=(), bent=np.zeros(0), acceleration=np.zeros(0))
    lost = unbent.filtered(p).innovations[moment, 0]
    assert np.std(innovations) < 0.1 * np.std(lost)


def test_of_two_beginnings_the_likelier_is_taken() -> None:
    """A simulation may begin unbent, where no machine does."""
    model, bench, p = prepared(play=0.0)
    count = len(bench.signals.y)
    for start in (bench._start, bench._balance.found(p[: len(model.kernel.parameters)], bench._start)):
        shown = replace(model.training, y=bench.simulated(p, start, 0, count))
        own = model.bench(shown, bench.noise, between=Between.HELD)
        kernels, *driven, parts = own._driven(p)
        begun = own._begin(kernels, (driven[0], driven[1], driven[2], np.ones((count, 0))), parts)
        arm = model.kernel.coordinates.index("arm")
        assert begun[arm] == pytest.approx(start[arm], abs=1e-3)
    assert abs(bench._start[arm] - start[arm]) > 0.02
