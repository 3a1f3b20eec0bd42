"""Several recordings as one, one as two: which samples fit and which judge."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.base.errors import InputError
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.findings import Verdict
from symdyn.numeric.recording import Recording
from symdyn.numeric.runs import joined, split, training_and_heldout

from .pendulum import pendulum, record, recording

KEYS = tuple(record(1, duration=1.0).channels)


def run_of(count: int, parts: tuple[slice, ...] = ()) -> Recording:
    time = np.arange(count) / 100.0
    return recording(time, np.arange(count, dtype=float), -np.arange(count, dtype=float), "run", parts)


def numbers(run: Recording) -> np.ndarray:
    """Which samples of ``run_of`` are in it."""
    return run.channels[KEYS[0]].astype(int)


@settings(deadline=None)
@given(st.integers(600, 5000))
def test_split_gives_disjoint_blocks_with_room_between(count: int) -> None:
    fitted, judge = (numbers(part) for part in split(run_of(count)))
    assert not set(fitted) & set(judge)
    nearest = np.min(np.abs(judge[:, None] - fitted[None, ::1]))
    assert nearest > 0.05 * count / 9
    assert 0.25 < len(judge) / (len(judge) + len(fitted)) < 0.4
    assert len(judge) + len(fitted) > 0.85 * count


def test_split_blocks_are_segments_and_keep_their_values() -> None:
    run = run_of(1800, (slice(0, 700), slice(700, 1800)))
    for part, blocks in zip(split(run), (3 + 1, 3), strict=True):  # the gap cuts a fitted block in two
        assert len(part.segments) == blocks
        assert [s.start for s in part.segments[1:]] == [s.stop for s in part.segments[:-1]]
        for segment in part.segments:
            assert np.all(np.diff(numbers(part)[segment]) == 1)
        np.testing.assert_allclose(part.time, numbers(part) / 100.0)
        np.testing.assert_array_equal(part.channels[KEYS[1]], -part.channels[KEYS[0]])


def test_what_is_too_short_is_not_split() -> None:
    with pytest.raises(InputError, match="too few to be split") as caught:
        split(run_of(599))
    assert caught.value.problems[0].code == "SD527"


def test_joined_runs_are_segments_one_after_the_other() -> None:
    both = joined([run_of(300), run_of(200, (slice(0, 50), slice(50, 200)))])
    assert both.segments == (slice(0, 300), slice(300, 350), slice(350, 500))
    assert np.all(np.diff(both.time) > 0)
    assert both.time[300] - both.time[299] > 5 * both.sample_time
    np.testing.assert_array_equal(numbers(both), [*range(300), *range(200)])
    assert joined([both]) is both


def test_runs_that_do_not_go_together_are_refused() -> None:
    run = run_of(300)
    slow = replace(run, time=2 * run.time, sample_time=2 * run.sample_time, name="slow")
    other = replace(run, channels=MappingProxyType({}), name="other")
    with pytest.raises(InputError) as caught:
        joined([run, slow, other])
    assert [problem.code for problem in caught.value.problems] == ["SD526", "SD526"]


def test_channels_that_one_run_lacks_are_left_out() -> None:
    run = run_of(300)
    less = replace(run, channels=MappingProxyType({KEYS[1]: run.channels[KEYS[1]]}))
    assert tuple(joined([run, less]).channels) == (KEYS[1],)


def test_heldout_given_is_taken_as_it_is() -> None:
    training, heldout = training_and_heldout([run_of(300)], run_of(200))
    assert (len(training.time), len(heldout.time)) == (300, 200)


@pytest.mark.slow  # whole diagnoses; the tests of the command have one
@pytest.mark.parametrize("runs", [1, 2])
def test_diagnosis_without_heldout_recording_judges_on_blocks(runs: int) -> None:
    recordings = [record(seed, lambda t, q, v, a: 0.3 * np.sign(v)) for seed in range(1, 1 + runs)]
    found = diagnose(pendulum(), recordings)
    assert found.verdict is Verdict.MISSING_PHYSICS
    ((finding,), estimate) = found.findings, found.findings[0].parameters["level"]
    assert finding.effect == "coulomb_friction"
    assert estimate.se is not None
    assert abs(estimate.value - 0.3) < max(4 * estimate.se, 0.01)
    assert "judging blocks" in found.heldout
