"""Encoders that are off by a gain or an offset, or whose steps hide what is left: named, and set right."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.compiler import robot_from_text
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.reading import Reading, declared
from symdyn.numeric.recording import Recording
from symdyn.spec.records import Quantity, Side

from .arm_of_two import ARM_OF_TWO, run

Array = NDArray[np.float64]


@pytest.mark.slow  # quicker: an offset at the first joint (test_revision)
@pytest.mark.parametrize(("fault", "value"), [("offset", 0.09), ("gain", 0.94)])
def test_an_encoder_that_is_off_is_named_and_set_right(fault: str, value: float) -> None:
    robot = robot_from_text(ARM_OF_TWO, "two.toml")
    found = diagnose(robot, run(1, **{fault: value}), run(2, **{fault: value}))
    assert [(f.effect, f.place) for f in found.findings] == [("encoder", "two")]
    told = found.findings[0].parameters[fault]
    assert told.se is not None
    assert told.value == pytest.approx(value, abs=max(4.0 * told.se, 1e-4))
    assert not found.remaining.structured
    assert declared(found.diagnosed)[1] == replace(Reading(), **{fault: pytest.approx(told.value, rel=1e-6)})


def in_steps(shown: Recording, step: float, trembling: float | Array = 0.0, joint: str = "two") -> Recording:
    """Its encoder of that joint has such steps (rad)."""
    at = Quantity.POSITION, joint, Side.LINK
    channels = dict(shown.channels)
    channels[at] = np.round(np.round((channels[at] + trembling) / step) * step, 6)
    return replace(shown, channels=channels)


@pytest.mark.slow  # whole diagnoses
@pytest.mark.parametrize("count", [1000, 100_000])
def test_the_steps_of_an_encoder_are_named_where_they_are_most_of_what_is_left(count: int) -> None:
    """Steps of 2 pi / 1000 hide the noise of the torques; those of 2 pi / 100 000 are hidden by it."""
    step = 2.0 * math.pi / count
    runs = [in_steps(run(seed), step) for seed in (1, 2)]
    found = diagnose(robot_from_text(ARM_OF_TWO, "two.toml"), *runs)
    coarse = count == 1000
    assert [(f.effect, f.place) for f in found.findings] == ([("encoder", "two")] if coarse else [])
    assert not found.remaining.structured
    if coarse:
        told = found.findings[0].parameters["resolution"]
        assert told.se is not None
        assert told.value == pytest.approx(step, abs=4.0 * told.se)
        assert told.se < 1e-4 * step
        assert diagnose(found.diagnosed, *runs).findings == ()  # it is known now


@pytest.mark.slow
@pytest.mark.parametrize("shaken", [1e-3, 3e-3])
def test_what_is_quicker_than_an_encoder_can_tell_is_not_tested(shaken: float) -> None:
    """It shakes by a part of its steps: the torque of that is most of what is left, and nobody saw the motion."""
    runs = [in_steps(run(seed, shaken=shaken), 0.012) for seed in (1, 2)]
    found = diagnose(robot_from_text(ARM_OF_TWO, "two.toml"), *runs)
    assert [(f.effect, f.place) for f in found.findings] == [("encoder", "two")]
    assert found.band < 8.0
    assert any("nothing above" in alarm for alarm in found.alarms), found.alarms
    assert found.model["b2"].value == pytest.approx(0.12, rel=0.01)
    assert not found.remaining.structured


@pytest.mark.slow
def test_a_band_that_ended_for_one_joint_does_not_open_for_the_next() -> None:
    runs = [in_steps(in_steps(run(seed, shaken=3e-3), 0.03), 0.02, joint="one") for seed in (1, 2)]
    found = diagnose(robot_from_text(ARM_OF_TWO, "two.toml"), *runs)
    assert {f.effect for f in found.findings} == {"encoder"}
    assert found.band < 1.0
    assert not found.remaining.structured


@pytest.mark.slow
def test_an_encoder_that_trembles_by_more_than_its_steps_has_none_that_matter() -> None:
    rng, step = np.random.default_rng(0), 1e-3
    runs = [in_steps(run(seed), step, step * rng.standard_normal(10_000)) for seed in (1, 2)]
    assert diagnose(robot_from_text(ARM_OF_TWO, "two.toml"), *runs).findings == ()


@pytest.mark.slow
def test_an_encoder_is_set_right_beside_a_later_finding() -> None:
    """Its offset was fitted first, and took up some of what the rotor does."""
    found = diagnose(robot_from_text(ARM_OF_TWO, "two.toml"), *(run(s, offset=0.07, rotor=0.02) for s in (1, 2)))
    assert {(f.effect, f.place) for f in found.findings} == {("encoder", "two"), ("added_inertia", "two")}
    told = {name: e for f in found.findings for name, e in f.parameters.items()}
    for name, value in (("offset", 0.07), ("inertia", 0.02)):
        se = told[name].se
        assert se is not None
        assert told[name].value == pytest.approx(value, abs=max(4.0 * se, 1e-3 * value))
