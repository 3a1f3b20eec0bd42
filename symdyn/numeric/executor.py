"""Maps a pure function over tasks: in processes of this machine (joblib) or on a cluster (dask.distributed).

The same tasks give the same numbers, whatever the number of workers: results are ordered as their tasks, and a
task's seed follows from its content. What is done stays on disk, so that a run that was killed goes on.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from symdyn import __version__
from symdyn.base.errors import Problem, UsageError
from symdyn.base.files import write_atomically

Task = Mapping[str, Any]  # plain data, as JSON has it
Function = Callable[[Task, int], Any]  # (task, seed) -> plain data; of a module, so that other processes find it
Progress = Callable[[str], None]

_CONNECT = "10s"  # before a scheduler counts as not there


@dataclass(frozen=True, slots=True)
class Executor:
    """``jobs`` processes here (0: one per core), or the cluster of a ``scheduler`` (``tcp://host:port``).

    ``store`` is a folder where results are kept, one JSON file per task, named by the task's content.
    """

    jobs: int = 1
    scheduler: str | None = None
    store: Path | None = None

    def map(
        self, function: Function, tasks: Sequence[Task], what: str = "tasks", progress: Progress = lambda _: None
    ) -> list[Any]:
        """``[function(task, seed), ...]`` in the order of the tasks; a task that occurs twice is done once.

        Results are what JSON keeps of them: tuples become lists, floats keep every bit.

        Raises UsageError (SD340) for a number of jobs that is none, a scheduler that does not answer, or dask where
        it is not installed; what ``function`` raises ends the run, and what was done before it stays in the store.
        """
        if self.jobs < 0:
            raise UsageError(Problem("SD340", f"--jobs {self.jobs}: a number of processes, or 0 for one per core"))
        keys = [task_key(function, task) for task in tasks]
        found = {key: kept for key in keys if (kept := self._kept(key)) is not None}
        open_ = {key: task for key, task in zip(keys, tasks, strict=True) if key not in found}
        total = len(found) + len(open_)
        progress(f"step {len(found)} of {total} {what}")
        for key, result in self._done(function, open_):
            found[key] = _Kept(json.loads(json.dumps(result)))
            if self.store is not None:
                write_atomically(self._path(key), json.dumps({"task": open_[key], "result": result}))
            progress(f"step {len(found)} of {total} {what}")
        return [found[key].result for key in keys]

    def _done(self, function: Function, open_: Mapping[str, Task]) -> Iterator[tuple[str, Any]]:
        if not open_:
            return iter(())
        if self.scheduler is not None:
            return _on_cluster(function, open_, self.scheduler)
        jobs = min(self.jobs or os.cpu_count() or 1, len(open_))
        return _in_processes(function, open_, jobs) if jobs > 1 else _here(function, open_)

    def _path(self, key: str) -> Path:
        assert self.store is not None
        return self.store / f"{key}.json"

    def _kept(self, key: str) -> _Kept | None:
        """A result of an earlier run; None where there is none, or none that can be read."""
        if self.store is None or not self._path(key).is_file():
            return None
        try:
            return _Kept(json.loads(self._path(key).read_text(encoding="utf-8"))["result"])
        except (ValueError, KeyError, TypeError):
            return None


@dataclass(frozen=True, slots=True)
class _Kept:
    result: Any


def task_key(function: Function, task: Task) -> str:
    """The content of a task as a name: the function, this version of symdyn, and the task itself."""
    text = json.dumps([function.__module__, function.__qualname__, __version__, task], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _one(function: Function, key: str, task: Task) -> tuple[str, Any]:
    with threadpool_limits(1):  # the tasks are what runs at the same time
        return key, function(task, int(key[:8], 16))


def _here(function: Function, open_: Mapping[str, Task]) -> Iterator[tuple[str, Any]]:
    return (_one(function, key, task) for key, task in open_.items())


def _in_processes(function: Function, open_: Mapping[str, Task], jobs: int) -> Iterator[tuple[str, Any]]:
    from joblib import Parallel, delayed, parallel_config

    with parallel_config(backend="loky", inner_max_num_threads=1):
        # Nothing is written to disk for the workers to read: no memory maps of arguments.
        run = Parallel(n_jobs=jobs, return_as="generator_unordered", max_nbytes=None, batch_size=1)
        yield from run(delayed(_one)(function, key, task) for key, task in open_.items())


def _on_cluster(function: Function, open_: Mapping[str, Task], scheduler: str) -> Iterator[tuple[str, Any]]:
    try:
        from distributed import Client, as_completed
    except ImportError:
        hint = "pip install 'symdyn[cluster]'"
        raise UsageError(Problem("SD340", "a scheduler needs dask.distributed", hint=hint)) from None
    try:
        client = Client(scheduler, set_as_default=False, timeout=_CONNECT)
    except (OSError, ValueError) as error:
        hint = "start one with `dask scheduler`, and workers with `dask worker ADDRESS`"
        raise UsageError(Problem("SD340", f"no scheduler answers at {scheduler}: {error}", hint=hint)) from None
    with client:
        futures = [client.submit(_one, function, key, task, key=f"symdyn-{key}") for key, task in open_.items()]
        for _, result in as_completed(futures, loop=client.loop, with_results=True):
            yield result
