"""The executor: the same numbers whoever does the work, in order, and a run that was killed goes on."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from symdyn.base.errors import UsageError
from symdyn.numeric.executor import Executor, task_key
from tests.numeric.tasks import draw, fails, noted

CHECKOUT = Path(__file__).parent.parent.parent
TASKS = [{"x": x} for x in range(7)]
RUN = """
from pathlib import Path
import sys
from symdyn.numeric.executor import Executor
from tests.numeric.tasks import noted
tasks = [{"x": x, "notes": sys.argv[2], "kills": x == 4} for x in range(7)]
print(Executor(store=Path(sys.argv[1])).map(noted, tasks))
"""


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """A cluster on loopback: two processes that know nothing of each other."""
    distributed = pytest.importorskip("distributed", reason="dask.distributed (the extra `cluster`) is not installed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=":0"
    ) as cluster:
        yield cluster.scheduler_address


def test_processes_give_the_numbers_of_one() -> None:
    alone = Executor(1).map(draw, TASKS)
    assert Executor(3).map(draw, TASKS) == alone
    assert [result["x"] for result in alone] == list(range(7))
    assert len({tuple(result["drawn"]) for result in alone}) == 7  # every task has a seed of its own
    assert alone[0]["pair"] == [1, 2]  # what JSON keeps, also where nothing was written


@pytest.mark.filterwarnings("ignore::ResourceWarning")  # dask's own sockets, closed when they are collected
def test_cluster_gives_the_numbers_of_one(scheduler: str) -> None:
    assert Executor(scheduler=scheduler).map(draw, TASKS) == Executor(1).map(draw, TASKS)


def test_numbers_do_not_depend_on_what_else_is_done() -> None:
    alone = Executor(1).map(draw, [TASKS[5]])
    assert Executor(2).map(draw, TASKS)[5] == alone[0]


def test_task_that_occurs_twice_is_done_once(tmp_path: Path) -> None:
    notes = tmp_path / "notes"
    task = {"x": 2, "notes": str(notes)}
    assert Executor().map(noted, [task, task]) == [4, 4]
    assert notes.read_text() == "2\n"


def test_run_that_was_killed_goes_on(tmp_path: Path) -> None:
    store, notes = tmp_path / "store", tmp_path / "notes"
    command = [sys.executable, "-c", RUN, str(store), str(notes)]
    killed = subprocess.run(command, cwd=CHECKOUT, capture_output=True, text=True, timeout=120)
    assert killed.returncode == -9
    assert notes.read_text().split() == ["0", "1", "2", "3"]
    assert len(list(store.glob("*.json"))) == 4
    went_on = subprocess.run(command, cwd=CHECKOUT, capture_output=True, text=True, timeout=120)
    assert went_on.stdout.strip() == str([x**2 for x in range(7)])
    assert notes.read_text().split() == [str(x) for x in range(7)]  # nothing was done twice


def test_results_are_named_by_content(tmp_path: Path) -> None:
    Executor(store=tmp_path).map(draw, TASKS)
    assert {path.stem for path in tmp_path.iterdir()} == {task_key(draw, task) for task in TASKS}
    assert task_key(draw, {"a": 1, "b": 2}) == task_key(draw, {"b": 2, "a": 1})
    assert task_key(draw, {"x": 1}) != task_key(noted, {"x": 1})


def test_result_that_cannot_be_read_is_found_anew(tmp_path: Path) -> None:
    whole = Executor(store=tmp_path).map(draw, TASKS)
    (tmp_path / f"{task_key(draw, TASKS[0])}.json").write_text("{")
    (tmp_path / f"{task_key(draw, TASKS[1])}.json").write_text("[]")
    assert Executor(store=tmp_path).map(draw, TASKS) == whole
    assert json.loads((tmp_path / f"{task_key(draw, TASKS[0])}.json").read_text())["result"] == whole[0]


@pytest.mark.parametrize("jobs", [1, 2])
def test_task_that_fails_ends_the_run_and_the_rest_is_kept(tmp_path: Path, jobs: int) -> None:
    tasks = [{"x": x} for x in (0, 1, 2, 3)]
    with pytest.raises(ValueError, match="three is too much"):
        Executor(jobs, store=tmp_path).map(fails, tasks)
    if jobs == 1:
        assert len(list(tmp_path.iterdir())) == 3


def test_progress_counts_what_is_done() -> None:
    told: list[str] = []
    Executor().map(draw, TASKS[:2], "draws", told.append)
    assert told == ["step 0 of 2 draws", "step 1 of 2 draws", "step 2 of 2 draws"]


def test_bad_requests_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UsageError, match="SD340"):
        Executor(-1).map(draw, TASKS)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(UsageError, match=r"dask\.distributed"):
        Executor(scheduler="tcp://127.0.0.1:9").map(draw, TASKS)


@pytest.mark.filterwarnings("ignore::ResourceWarning")  # dask's own sockets, closed when they are collected
def test_scheduler_that_does_not_answer_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="dask.distributed (the extra `cluster`) is not installed")
    monkeypatch.setattr("symdyn.numeric.executor._CONNECT", "1s")
    with pytest.raises(UsageError, match="no scheduler answers"):
        Executor(scheduler="tcp://127.0.0.1:9").map(draw, TASKS)
