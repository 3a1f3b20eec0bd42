"""What sensors do to a channel, each planted in a signal and found there with its size; clean signals pass."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symdyn.base.errors import BadRecording, Problem
from symdyn.numeric.recording import Recording, read_recording
from symdyn.numeric.recording_quality import clipped, quantisation_noise, skew
from symdyn.spec.records import Channel, ChannelMap, Quantity, Side

STEP = 1e-3
TIME = STEP * np.arange(4000)
Q = np.sin(3 * TIME) + 0.3 * np.sin(7.3 * TIME)
QD = 3 * np.cos(3 * TIME) + 0.3 * 7.3 * np.cos(7.3 * TIME)


def noise(size: float, seed: int = 0) -> np.ndarray:
    return size * np.random.default_rng(seed).standard_normal(len(TIME))


TAU = 2 * np.cos(3 * TIME + 0.4) + 0.7 * np.cos(11 * TIME) + noise(0.01)


def rounded(values: np.ndarray, step: float) -> np.ndarray:
    return step * np.round(values / step)


def channel(column: str, quantity: Quantity, unit: str) -> Channel:
    return Channel(column, quantity, joint="arm", side=Side.LINK, unit=unit, factor=1.0)


MAP = ChannelMap(
    "t",
    1.0,
    (
        channel("q", Quantity.POSITION, "rad"),
        channel("v", Quantity.VELOCITY, "rad/s"),
        channel("tau", Quantity.EFFORT, "N m"),
        channel("u", Quantity.VOLTAGE, "V"),
    ),
)


def read(path: Path, **columns: np.ndarray) -> Recording:
    table = {"t": TIME, "q": Q, "v": QD, "tau": TAU, "u": TAU, **columns}
    np.savetxt(
        path / "run.csv", np.column_stack(list(table.values())), delimiter=",", header=",".join(table), comments=""
    )
    return read_recording(path / "run.csv", MAP)


def codes(problems: tuple[Problem, ...]) -> list[str]:
    return [problem.code for problem in problems]


def test_a_clean_recording_has_no_warnings(tmp_path: Path) -> None:
    assert read(tmp_path).warnings == ()


@pytest.mark.parametrize("column", ["tau", "u"])
@pytest.mark.parametrize("level", [1.0, 2.0, 2.4])
def test_clipping_is_found_with_its_level(column: str, level: float, tmp_path: Path) -> None:
    cut = np.clip(TAU, -level, level)
    share, end = clipped(cut)
    lost = max(np.mean(cut == level), np.mean(cut == -level))
    assert share == pytest.approx(lost, abs=0.01)
    assert abs(end) == level
    if column == "tau" and lost > 0.06:
        with pytest.raises(BadRecording, match="end of its range") as caught:
            read(tmp_path, tau=cut)
        assert codes(caught.value.problems) == ["SD524"]
    elif column == "u":
        assert codes(read(tmp_path, u=cut).warnings) == ["SD524"]


@pytest.mark.parametrize(
    "values",
    [
        Q,
        rounded(Q, 0.01),
        rounded(TAU, 0.05),
        np.sign(np.sin(5 * TIME)),  # switched
        np.where(TIME < 2.5, 0.0, np.maximum(TAU, 0.0)),  # mostly idle
    ],
)
def test_signals_that_rest_or_switch_are_not_clipped(values: np.ndarray) -> None:
    assert clipped(values)[0] < 0.002


@pytest.mark.parametrize("step", [1e-3, 0.02, 0.2])
def test_steps_of_quantisation_are_found(step: float) -> None:
    assert quantisation_noise(rounded(TAU, step)) == pytest.approx(step / np.sqrt(12), rel=1e-6)


def test_what_has_no_steps_has_no_noise_of_them() -> None:
    assert quantisation_noise(TAU) == 0.0
    assert quantisation_noise(np.zeros(100)) == 0.0


def test_coarse_steps_are_told_as_a_noise_floor(tmp_path: Path) -> None:
    recording = read(tmp_path, tau=rounded(TAU, 0.2))
    (warning,) = recording.warnings
    assert warning.code == "SD525"
    assert "steps of 0.2" in warning.message
    assert recording.quantisation[Quantity.EFFORT, "arm", Side.LINK] == pytest.approx(0.2 / np.sqrt(12))


@pytest.mark.parametrize("delay", [-0.03, 0.004, 0.02])
def test_skew_is_estimated_with_its_error(delay: float) -> None:
    rng = np.random.default_rng(3)
    time = STEP * np.arange(20000)
    rates, phases = rng.uniform(2, 60, 40), rng.uniform(0, 6, 40)

    def signal(t: np.ndarray) -> np.ndarray:
        return np.asarray(np.cos(np.outer(t, rates) + phases).sum(axis=1))

    early, late = signal(time), signal(time - delay)
    found = skew(early + 0.05 * rng.standard_normal(len(time)), late + 0.05 * rng.standard_normal(len(time)), STEP)
    assert found is not None
    assert abs(found.delay - delay) < max(4 * found.se, 0.02 * abs(delay))
    assert 0 < found.se < 1e-3


def test_skew_of_noise_is_not_told() -> None:
    assert skew(noise(1.0, 1), noise(1.0, 2), STEP) is None


def test_velocity_that_is_late_is_told(tmp_path: Path) -> None:
    rates = np.linspace(5, 60, 23)

    def position(t: np.ndarray) -> np.ndarray:
        return np.asarray(np.sin(np.outer(t, rates) + rates**2).sum(axis=1))

    def velocity(t: np.ndarray) -> np.ndarray:
        return np.asarray(np.cos(np.outer(t, rates) + rates**2) @ rates)

    assert read(tmp_path, q=position(TIME), v=velocity(TIME)).warnings == ()
    (warning,) = read(tmp_path, q=position(TIME), v=velocity(TIME - 0.004)).warnings
    assert warning.code == "SD528"
    assert "0.004 +-" in warning.message


@pytest.mark.parametrize(("jitter", "bad"), [(0.05, None), (0.2, False), (0.7, True)])
def test_jitter_of_the_clock(jitter: float, bad: bool | None, tmp_path: Path) -> None:
    steps = STEP * jitter**2 * np.random.default_rng(4).gamma(jitter**-2, size=len(TIME))
    time = np.cumsum(steps)
    columns = {"t": time, "q": np.sin(3 * time), "v": 3 * np.cos(3 * time)}
    if bad:
        with pytest.raises(BadRecording, match="clock jitters") as caught:
            read(tmp_path, **columns)
        assert "SD509" in codes(caught.value.problems)
    else:
        assert codes(read(tmp_path, **columns).warnings) == ([] if bad is None else ["SD509"])
