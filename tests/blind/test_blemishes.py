"""What is done to a recording is what the name says, and nothing else."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from benchmarks.blind import blemishes
from benchmarks.blind.blemishes import BLEMISHES, REFUSED
from benchmarks.blind.machine import Recorded
from benchmarks.blind.motions import rng_of

STEP = 0.002


def x(time: np.ndarray) -> np.ndarray:
    return np.sin(2.0 * np.pi * 0.7 * time)


def y(time: np.ndarray) -> np.ndarray:
    return 3.0 * np.cos(2.0 * np.pi * 0.4 * time)


SOUND = Recorded.even(STEP, {"x1": x(STEP * np.arange(2500)), "y1": y(STEP * np.arange(2500)), "y2": np.arange(2500.0)})


def spoiled(kind: str) -> Recorded:
    return BLEMISHES[kind](rng_of(kind), SOUND)


def changed(found: Recorded, name: str) -> np.ndarray:
    return np.flatnonzero(found.columns[name] != SOUND.columns[name])


@pytest.mark.parametrize("kind", BLEMISHES)
def test_the_same_every_time_and_the_sound_one_stays(kind: str) -> None:
    before = SOUND.csv()
    assert spoiled(kind).csv() == spoiled(kind).csv() != before == SOUND.csv()
    assert np.all(np.diff(spoiled(kind).time) > 0)
    assert REFUSED.keys() < BLEMISHES.keys()


@pytest.mark.parametrize(("kind", "moved"), [("uneven_clock", True), ("trembling_stamps", False)])
def test_clocks_tremble_by_a_tenth_of_a_step(kind: str, moved: bool) -> None:
    found = spoiled(kind)
    off = found.time - SOUND.time
    assert np.std(off) == pytest.approx(blemishes.UNEVEN * STEP, rel=0.1)
    true = x(found.time if moved else SOUND.time)
    np.testing.assert_allclose(found.columns["x1"], true, atol=1e-9)


def test_angles_start_again_after_a_turn() -> None:
    angle = spoiled("turned_angles").columns["x1"]
    assert 0.0 <= angle.min() < angle.max() < 2.0 * math.pi
    np.testing.assert_allclose(np.sin(angle), np.sin(SOUND.columns["x1"]), atol=1e-12)


def test_rows_repeat_and_are_lost() -> None:
    twice, fewer = spoiled("repeated_rows"), spoiled("lost_rows")
    assert np.array_equal(twice.columns["y1"][::2], SOUND.columns["y1"])
    assert np.array_equal(twice.columns["y1"][::2], twice.columns["y1"][1::2])
    assert twice.time[-1] == pytest.approx(SOUND.time[-1], abs=STEP)
    assert 0.98 < len(fewer.time) / len(SOUND.time) < 1.0
    assert np.isin(fewer.time, SOUND.time).all()
    assert np.array_equal(fewer.columns["x1"], x(fewer.time))


def test_samples_stand_alone() -> None:
    found = spoiled("stray_samples")
    where = changed(found, "x1")
    assert len(where) == blemishes.STRAY
    assert np.abs(found.columns["x1"] - SOUND.columns["x1"])[where].min() >= 1.0
    assert not len(changed(found, "y1"))


def test_filters_start_and_sensors_stop() -> None:
    start, end = spoiled("filter_start"), spoiled("still_end")
    assert start.columns["y1"][0] == 0.0
    after = SOUND.time > 10.0 * blemishes.START
    np.testing.assert_allclose(start.columns["y1"][after], SOUND.columns["y1"][after], rtol=1e-4)
    assert np.ptp(end.columns["y2"][end.time > end.time[-1] - 0.9 * blemishes.STILL]) == 0.0
    assert changed(end, "y2").min() * STEP == pytest.approx(end.time[-1] - blemishes.STILL, abs=2 * STEP)


@pytest.mark.parametrize(
    ("kind", "name", "expected"),
    [
        ("flipped_efforts", "y2", lambda sound: -sound["y2"]),
        ("flipped_position", "x1", lambda sound: -sound["x1"]),
        ("exchanged_efforts", "y1", lambda sound: sound["y2"]),
        ("degrees", "x1", lambda sound: np.degrees(sound["x1"])),
        ("clipped_efforts", "y1", lambda sound: np.clip(sound["y1"], -1.8, 1.8)),
    ],
)
def test_channels_are_another_quantity(
    kind: str, name: str, expected: Callable[[dict[str, np.ndarray]], np.ndarray]
) -> None:
    np.testing.assert_allclose(spoiled(kind).columns[name], expected(dict(SOUND.columns)), atol=1e-5)


def test_milliseconds() -> None:
    np.testing.assert_allclose(spoiled("milliseconds").time, 1e3 * SOUND.time)
