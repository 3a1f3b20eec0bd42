"""Angles that start again after a turn, and rows that were written more than once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.recording import Recording, read_recording
from symdyn.spec.records import Channel, ChannelMap, Quantity, Side

from .pendulum import ANGLE_NOISE, ARM, GRAVITY, MASS, TORQUE_NOISE, TURNING, VISCOUS, motion, pendulum

Array = NDArray[np.float64]

TIME = np.arange(8000) / 400.0
ANGLE = (Quantity.POSITION, "arm", Side.LINK)


def turning(seed: int, dry: float = 0.0, amplitude: float = 6.0) -> tuple[Array, Array]:
    """A pendulum that goes right round."""
    rng = np.random.default_rng([seed, 5])
    q, v, a = motion(seed, TIME, amplitude)
    tau = TURNING * a + VISCOUS * v + MASS * GRAVITY * ARM * np.cos(q) + dry * np.sign(v)
    noise = rng.standard_normal((2, len(TIME)))
    return q + ANGLE_NOISE * noise[0], tau + TORQUE_NOISE * noise[1]


def read(folder: Path, q: Array, tau: Array, unit: str = "rad", factor: float = 1.0, scale: float = 1.0) -> Recording:
    path = folder / "run.csv"
    columns = np.column_stack([TIME[: len(q)], q, tau])
    np.savetxt(path, columns, delimiter=",", header="t,q,tau", comments="", fmt="%.9g")
    position = Channel("q", Quantity.POSITION, "arm", Side.LINK, unit, factor, scale)
    effort = Channel("tau", Quantity.EFFORT, "arm", Side.LINK, "N m", 1.0)
    return read_recording(path, ChannelMap("t", 1.0, (position, effort)))


def codes(recording: Recording) -> list[str]:
    return [problem.code for problem in recording.warnings if problem.code in ("SD531", "SD532")]


@pytest.mark.parametrize(
    ("unit", "factor", "scale", "turn"),
    [
        ("rad", 1.0, 1.0, 2.0 * np.pi),
        ("deg", np.pi / 180.0, 1.0, 360.0),
        ("rev", 2.0 * np.pi, 1.0, 1.0),
        ("rad", 1.0, 2.0 * np.pi / 4096, 4096.0),  # counts of the joint's encoder
        ("rad", 1.0, 0.01, 2.0 * np.pi),  # of a motor before a gear of 100
    ],
)
def test_whole_turns_are_added(unit: str, factor: float, scale: float, turn: float, tmp_path: Path) -> None:
    q, tau = turning(1)
    if turn == 2.0 * np.pi and scale == 0.01:
        q = 0.3 * q  # slow enough for a motor's encoder to be followed
    column = q / (factor * scale)
    found = read(tmp_path, (column + turn / 2.0) % turn - turn / 2.0, tau, unit, factor, scale)
    assert codes(found) == ["SD531"]
    back = found.channels[ANGLE] - q
    assert np.ptp(back) < 1e-6
    assert back[0] / (turn * factor * scale) == pytest.approx(round(back[0] / (turn * factor * scale)), abs=1e-6)


@pytest.mark.parametrize("amplitude", [1.2, 6.0])
def test_an_angle_that_goes_on_is_left_alone(amplitude: float, tmp_path: Path) -> None:
    q, tau = turning(1, amplitude=amplitude)
    found = read(tmp_path, q, tau)
    assert codes(found) == []
    assert found.channels[ANGLE] == pytest.approx(q, abs=1e-7)


def test_a_single_spike_is_no_turn(tmp_path: Path) -> None:
    q, tau = turning(1, amplitude=1.2)
    q[3000] += 4.0
    assert codes(read(tmp_path, q, tau)) == []


@pytest.mark.parametrize("times", [2, 4, 5])
def test_rows_that_were_written_again_are_left_out(times: int, tmp_path: Path) -> None:
    q, tau = turning(1, amplitude=1.2)
    q, tau = q[::times], tau[::times]
    rng = np.random.default_rng(1)
    often = np.full(len(q), times) + rng.choice([0, 0, 0, 0, 0, 1], len(q))  # a logger is never quite as even
    found = read(tmp_path, np.repeat(q, often)[: len(TIME)], np.repeat(tau, often)[: len(TIME)])
    assert codes(found) == ["SD532"]
    kept = found.channels[ANGLE]
    assert kept == pytest.approx(q[: len(kept)], abs=1e-7)


def test_a_machine_that_rests_repeats_nothing(tmp_path: Path) -> None:
    """An exact standstill, with an encoder of steps and an effort that stays, where the motion turns back."""
    q, tau = (column[:6000] for column in turning(1, amplitude=1.2))
    at = 2000 + int(np.argmax(q[2000:4000]))
    q, tau = (np.insert(column, at, np.full(2000, column[at])) for column in (np.round(q, 4), np.round(tau, 2)))
    found = read(tmp_path, q, tau)
    assert codes(found) == []
    assert len(found.time) == len(TIME)


@pytest.mark.slow
def test_what_was_repeated_is_no_physics(tmp_path: Path) -> None:
    runs = []
    for seed in (1, 2):
        q, tau = turning(seed, dry=0.3)
        wrapped = (q + np.pi) % (2.0 * np.pi) - np.pi
        runs.append(read(tmp_path, np.repeat(wrapped[::2], 2), np.repeat(tau[::2], 2)))
        assert codes(runs[-1]) == ["SD532", "SD531"]
    told = diagnose(pendulum(), *runs)
    assert [finding.effect for finding in told.findings] == ["coulomb_friction"]
    assert told.findings[0].parameters["level"].value == pytest.approx(0.3, abs=0.003)
