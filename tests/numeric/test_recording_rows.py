"""Rows that show no motion are left out, and told; sudden things that a machine does are left in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symdyn.base.errors import BadRecording
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Verdict
from symdyn.numeric.recording import Recording

from .pendulum import pendulum
from .test_recording_repeats import TIME, Array, read, turning

STEP = float(TIME[1])


def codes(recording: Recording) -> list[str]:
    return [problem.code for problem in recording.warnings if problem.code in ("SD535", "SD536")]


def settling(values: Array, time_constant: float = 0.02) -> Array:
    """Behind a filter that started from zero."""
    return (1.0 - np.exp(-TIME / time_constant)) * values


@pytest.mark.parametrize("where", [slice(3000, 3200), slice(7800, 8000), slice(0, 200)], ids=["middle", "end", "start"])
def test_a_logger_that_stopped_shows_nothing(where: slice, tmp_path: Path) -> None:
    q, tau = turning(1, amplitude=1.2)
    held = where.stop - 1 if where.start == 0 else where.start
    for column in (q, tau):
        column[where] = column[held]
    found = read(tmp_path, q, tau)
    assert codes(found) == ["SD535"]
    kept = np.round(found.time / STEP).astype(int)
    assert 199 <= len(TIME) - len(kept) <= 200
    assert np.all((kept <= where.start) | (kept >= where.stop - 1))
    assert len(found.segments) == (2 if where.start == 3000 else 1)


@pytest.mark.parametrize("at_end", [False, True])
def test_a_filter_that_has_not_settled_is_left_out(at_end: bool, tmp_path: Path) -> None:
    q, tau = turning(1, amplitude=1.2)
    q += 0.5
    shown = [settling(q[::-1])[::-1], settling(tau[::-1])[::-1]] if at_end else [settling(q), settling(tau)]
    found = read(tmp_path, *shown)
    assert codes(found) == ["SD536"]
    kept = np.round(found.time / STEP).astype(int)
    assert 20 < len(TIME) - len(kept) < 200
    sound = np.array([column[kept] for column in (q, tau)])
    assert np.array(list(found.channels.values())) == pytest.approx(sound, abs=2e-3)


@pytest.mark.parametrize(
    "change",
    [
        lambda q, tau: (q, tau),
        lambda q, tau: (q, np.where(TIME < 0.1, 0.0, tau) if abs(tau[40]) < 1.0 else tau),
        lambda q, tau: (np.round(q, 2), np.round(tau, 1)),  # coarse: rows repeat here and there
        lambda q, tau: (np.exp(-TIME / 0.05), 5.0 * np.exp(-TIME / 0.05)),  # a step that settles, and nothing after it
        lambda q, tau: (np.exp(-TIME / 5.0) * np.cos(8.0 * TIME), 0.0 * tau),  # let go
        lambda q, tau: (np.abs(q), np.sign(q) * tau),  # a stop, at each pass
        lambda q, tau: (q, tau + 3.0 * np.sign(np.gradient(q))),  # dry friction
    ],
    ids=["smooth", "switched", "coarse", "settling", "let go", "impacts", "dry"],
)
def test_what_a_machine_does_stays(change: object, tmp_path: Path) -> None:
    assert callable(change)
    found = read(tmp_path, *change(*turning(2, amplitude=1.2)))
    assert codes(found) == []
    assert len(found.time) == len(TIME)


def test_too_little_may_be_left(tmp_path: Path) -> None:
    q, tau = turning(1, amplitude=1.2)
    stop = 100 + int(np.argmax(np.abs(np.gradient(q)[100:190])))
    q[stop:], tau[stop:] = q[stop], tau[stop]
    with pytest.raises(BadRecording) as caught:
        read(tmp_path, q, tau)
    assert [problem.code for problem in caught.value.problems] == ["SD535", "SD508"]


@pytest.mark.slow
def test_rows_without_motion_are_no_physics(tmp_path: Path) -> None:
    runs = []
    for seed in (1, 2):
        q, tau = turning(seed, dry=0.3, amplitude=1.2)
        q, tau = settling(q + 1.0) - 1.0, settling(tau)
        stop = 7600 + int(np.argmax(np.abs(np.gradient(q)[7600:7900])))
        q[stop:], tau[stop:] = q[stop], tau[stop]
        runs.append(read(tmp_path, q, tau))
        assert codes(runs[-1]) == ["SD535", "SD536"]
    told = diagnose(pendulum(), *runs)
    assert told.verdict is Verdict.MISSING_PHYSICS
    assert [finding.effect for finding in told.findings] == ["coulomb_friction"]
    assert told.findings[0].parameters["level"].value == pytest.approx(0.3, abs=0.003)
    assert any("bends as it does nowhere else" in alarm for alarm in told.alarms)
