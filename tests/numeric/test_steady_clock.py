"""Clocks that tremble: samples taken when they say, and samples that were only written down then."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Verdict
from symdyn.numeric.position_spectrum import floor
from symdyn.numeric.recording import Recording
from symdyn.numeric.steady_clock import steady
from symdyn.spec.records import Quantity, Side

from .pendulum import (
    ANGLE_NOISE,
    ARM,
    GRAVITY,
    MASS,
    TORQUE_NOISE,
    TURNING,
    VISCOUS,
    motion,
    pendulum,
    recording,
)

Array = NDArray[np.float64]

RATE, DURATION = 200.0, 20.0
POSITION = (Quantity.POSITION, "arm", Side.LINK)


def trembling(seed: int, stamped: bool, dry: float = 0.0, parts: int = 1) -> Recording:
    """Steps that are off by a tenth on average; the samples were ``stamped`` when they were taken, or taken evenly."""
    rng = np.random.default_rng([seed, 2])
    even = np.arange(int(DURATION * RATE)) / RATE
    told = even + rng.uniform(-0.2, 0.2, len(even)) / RATE
    taken = told if stamped else even
    q, v, a = motion(seed, taken)
    tau = TURNING * a + VISCOUS * v + MASS * GRAVITY * ARM * np.cos(q) + dry * np.sign(v)
    noise = rng.standard_normal((2, len(even)))
    edges = np.linspace(0, len(even), parts + 1).astype(int)
    stretches = tuple(slice(int(i), int(j)) for i, j in pairwise(edges))
    return recording(told, q + ANGLE_NOISE * noise[0], tau + TORQUE_NOISE * noise[1], f"run-{seed}", stretches)


@pytest.mark.parametrize("parts", [1, 3])
def test_samples_are_found_between_those_that_were_taken(parts: int) -> None:
    shown = trembling(1, True, parts=parts)
    found = steady(shown)
    for part in found.segments:
        assert np.ptp(np.diff(found.time[part])) < 1e-9
        true = motion(1, found.time[part])[0]
        assert np.sqrt(np.mean((found.channels[POSITION][part] - true) ** 2)) < 1.2 * ANGLE_NOISE
    assert len(found.segments) == parts
    assert found.sample_time == pytest.approx(1.0 / RATE, rel=1e-3)


def test_samples_that_were_taken_evenly_stay_as_they_are() -> None:
    shown = trembling(1, False)
    found = steady(shown)
    assert found.channels is shown.channels
    assert found.time == pytest.approx(np.arange(len(shown.time)) / RATE, abs=1e-3)
    assert np.ptp(np.diff(found.time)) < 1e-9


@pytest.mark.parametrize("stamped", [True, False])
def test_positions_tremble_no_more_than_their_sensor(stamped: bool) -> None:
    found = steady(trembling(1, stamped))
    level = floor(found.channels[POSITION][:, None], found.segments, RATE)
    assert level == pytest.approx(2.0 * ANGLE_NOISE**2 / RATE, rel=0.4)


def test_an_even_clock_is_left_alone() -> None:
    time = np.arange(2000) / RATE
    shown = recording(time, np.sin(time), time)
    assert steady(shown) is shown


@pytest.mark.slow  # whole diagnoses
@pytest.mark.parametrize("stamped", [True, False])
def test_a_trembling_clock_is_no_physics(stamped: bool) -> None:
    complete = diagnose(pendulum(), trembling(1, stamped), trembling(2, stamped))
    assert (complete.verdict, complete.findings) == (Verdict.COMPLETE, ())
    dry = diagnose(pendulum(), trembling(1, stamped, 0.3), trembling(2, stamped, 0.3))
    (found,) = dry.findings
    assert (dry.verdict, found.effect) == (Verdict.MISSING_PHYSICS, "coulomb_friction")
    level = found.parameters["level"]
    assert level.se is not None
    assert abs(level.value - 0.3) < max(3.0 * level.se, 0.003)
