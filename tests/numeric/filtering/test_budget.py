"""A search that takes long ends early, after the same work on every machine, and says what it did not ask."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import pytest

from symdyn.numeric.filtering import diagnose
from symdyn.numeric.filtering.bench import FilterBench
from symdyn.numeric.filtering.between import Between
from symdyn.numeric.filtering.budget import ENOUGH, Budget, allowed, spend, within
from symdyn.numeric.filtering.model import prepare, without_latent
from symdyn.numeric.filtering.side_by_side import side_by_side
from symdyn.spec.records import Robot
from tests.numeric.filtering.drive import record


def test_what_runs_side_by_side_spends_from_the_budget_of_its_caller() -> None:
    with within(Budget(100.0)) as outer:
        side_by_side(spend, [10.0] * 9)
        assert outer.spent == pytest.approx(90.0)
        with within(Budget(1.0)) as inner:
            side_by_side(spend, [1.0, 2.0])
        spend(5.0)
    spend(1e9)  # nobody's
    assert (outer.spent, inner.spent) == (pytest.approx(95.0), pytest.approx(3.0))


def test_what_was_not_asked_is_told_once() -> None:
    assert allowed("anything, where there is no budget")
    with within(Budget(10.0)) as budget:
        assert allowed("play")
        spend(10.0)
        assert [allowed(question) for question in ("play", "a shaft", "play")] == [False] * 3
    assert budget.not_asked == ("play", "a shaft")


@dataclass(frozen=True)
class Found:
    alarms: tuple[str, ...] = ("one",)


@pytest.mark.parametrize(("thorough", "work", "told"), [(False, 1.0, 2), (True, 1.0, 1), (False, 0.9, 1)])
def test_a_diagnosis_tells_what_it_did_not_ask(
    monkeypatch: pytest.MonkeyPatch, thorough: bool, work: float, told: int
) -> None:
    def diagnosed(*_: Any) -> Found:
        spend(work * ENOUGH)
        allowed("play at gear")
        return Found()

    monkeypatch.setattr(diagnose, "_diagnosed", diagnosed)
    nothing = cast(Any, None)
    alarms = diagnose.diagnose_hidden(nothing, nothing, nothing, lambda _: None, thorough=thorough).alarms
    assert len(alarms) == told
    assert told == 1 or ("play at gear" in alarms[1] and "--thorough" in alarms[1])


def test_work_goes_with_the_samples_and_with_what_is_asked_of_a_run(robot: Robot, tmp_path: Path) -> None:
    run = record(tmp_path / "1.csv", robot, 1, coulomb=0.03)
    model = prepare(robot, run, run, only=("",))
    bench = model.bench(model.training, without_latent(model, model.training), Between.HELD)

    def work(bench: FilterBench, *names: str) -> float:
        with within(Budget(ENOUGH)) as budget:
            bench.filtered(model.values, names)
        return budget.spent

    alone, with_slopes, finer = work(bench), work(bench, *model.beliefs), work(bench.in_steps(4))
    assert alone == work(bench) > len(model.training.y)
    assert with_slopes > 1.2 * alone
    assert 3.5 < finer / alone < 4.5
    assert 1e4 * with_slopes < ENOUGH  # a drive of one coordinate is asked everything
