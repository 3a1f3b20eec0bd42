"""Signs, units and channels that were mistaken are told as that, and missing physics is not taken for them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from types import MappingProxyType

import numpy as np
import pytest

from symdyn.base.errors import BadRecording
from symdyn.compiler import robot_from_text
from symdyn.numeric.confused import Channels, check_confused
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Verdict
from symdyn.numeric.recording import Recording
from symdyn.numeric.setting import prepare
from symdyn.spec.records import ChannelMap, Quantity, Side

from .arm_of_two import ARM_OF_TWO, run
from .pendulum import pendulum, record

ARM = robot_from_text(ARM_OF_TWO, "two.toml")


def mistaken(recording: Recording, change: Callable[[Channels], Channels]) -> Recording:
    return replace(recording, channels=MappingProxyType(dict(change(recording.channels))))


def turned(quantity: Quantity, joint: str | None = None) -> Callable[[Channels], Channels]:
    return lambda channels: {
        key: -values if key[0] is quantity and joint in (None, key[1]) else values for key, values in channels.items()
    }


def scaled(factor: float) -> Callable[[Channels], Channels]:
    return lambda channels: {
        key: factor * values if key[0] is Quantity.POSITION else values for key, values in channels.items()
    }


def exchanged(channels: Channels) -> Channels:
    keys = [(Quantity.EFFORT, joint, Side.LINK) for joint in ("one", "two")]
    return {**channels, keys[0]: channels[keys[1]], keys[1]: channels[keys[0]]}


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (turned(Quantity.EFFORT, "one"), "the effort of 'one' has the other sign"),
        (turned(Quantity.EFFORT, "two"), "the effort of 'two' has the other sign"),
        (turned(Quantity.POSITION, "two"), "the position of 'two' has the other sign"),
        (turned(Quantity.EFFORT), "all efforts have the other sign"),
        (exchanged, "the efforts of 'one' and 'two' were taken for one another"),
    ],
)
def test_a_mistake_is_told_with_its_channel(change: Callable[[Channels], Channels], told: str) -> None:
    with pytest.raises(BadRecording) as caught:
        diagnose(ARM, mistaken(run(1), change), mistaken(run(2), change))
    (problem,) = caught.value.problems
    assert problem.code == "SD533"
    assert problem.message.startswith(told)


def test_a_sign_is_told_where_a_model_with_wrong_numbers_hides_it() -> None:
    """With half the mass the sign makes 3 % of what the model leaves; once fitted, nearly all of it."""
    light = robot_from_text(ARM_OF_TWO.replace('m2 = "0.7 kg"', 'm2 = "0.35 kg"'), "two.toml")
    runs = [mistaken(run(seed), turned(Quantity.POSITION, "two")) for seed in (1, 2)]
    with pytest.raises(BadRecording, match="the position of 'two' has the other sign"):
        diagnose(light, *runs)


@pytest.mark.parametrize(
    ("factor", "told"),
    [(180.0 / np.pi, "the angles are in degrees, not in rad"), (np.pi / 180.0, "the angles are in rad, not in deg")],
)
def test_angles_in_another_unit(factor: float, told: str) -> None:
    with pytest.raises(BadRecording) as caught:
        diagnose(ARM, *(mistaken(run(seed), scaled(factor)) for seed in (1, 2)))
    (problem,) = caught.value.problems
    assert problem.code == "SD506"
    assert problem.message.startswith(told)


@pytest.mark.parametrize(
    ("factor", "told"), [(1e3, "the time is in ms, not in s"), (1e6, "the time is in us"), (1e-3, "the time is in s")]
)
def test_time_in_another_unit(factor: float, told: str) -> None:
    """The last is a map that says ms of a column in s."""
    channels = ARM.channels or ChannelMap("t", 1.0 if factor > 1.0 else 1e-3, ())
    runs = [run(seed) for seed in (1, 2)]
    runs = [replace(r, time=factor * r.time, sample_time=factor * r.sample_time) for r in runs]
    with pytest.raises(BadRecording) as caught:
        diagnose(replace(ARM, channels=channels), *runs)
    (problem,) = caught.value.problems
    assert problem.code == "SD506"
    assert problem.message.startswith(told)


@pytest.mark.parametrize(
    "moved",
    [
        run,
        partial(run, gain=0.8),
        partial(run, rotor=0.2),
        partial(run, by_load=0.3),
        partial(run, shown=(1.0, 0.6)),
        partial(run, carried=(1.0, 0.1, 0.1)),
    ],
)
def test_missing_physics_is_no_mistake(moved: Callable[[int], Recording]) -> None:
    recordings = [moved(seed) for seed in (1, 2)]
    setting = prepare(ARM, *recordings, lambda _: None)
    case = setting.case(setting.given())
    check_confused(setting, case, case.explain())


@pytest.mark.slow  # a whole diagnosis
def test_large_friction_of_a_pendulum_is_no_mistake() -> None:
    runs = [record(seed, lambda t, q, v, a: 6.0 * np.sign(v)) for seed in (1, 2)]
    told = diagnose(pendulum(), *runs)
    assert (told.verdict, told.findings[0].effect) == (Verdict.MISSING_PHYSICS, "coulomb_friction")
    assert told.before.heldout > 0.1
