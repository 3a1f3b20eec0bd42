"""Runs cases: plant, ask, keep the record; through symdyn's executor, so that a run that was killed goes on."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from benchmarks.blind.cases import Case, case_of, model, oracle_model, recordings
from benchmarks.blind.tool import IDENTIFY, ask
from symdyn.numeric.executor import Executor, Progress, Task


@dataclass(frozen=True)
class Setting:
    """How the tool is asked; ``limit`` in s for each case."""

    command: tuple[str, ...]
    oracle: bool
    limit: float


def run_all(cases: Sequence[Case], setting: Setting, executor: Executor, progress: Progress) -> list[dict[str, Any]]:
    """The records of the cases; what lies in the executor's store is not asked again."""
    return executor.map(run_task, [_task(case, setting) for case in cases], "cases", progress)


def run_task(task: Task, _: int) -> dict[str, Any]:
    """The record of one case: truth, answer, time, and the error that is left to one who knows the truth."""
    case = case_of(task["case"])
    training, heldout = recordings(case)
    answer = ask(task["command"], model(case), training, heldout, task["limit"])
    band = (answer.facts or {}).get("band_hz")
    oracle = None
    if task["oracle"] and band and all(plant.known for plant in case.planted):
        # The true structure, fitted to the held-out run itself: what is left is what no better answer could avoid.
        known = ask((*IDENTIFY, "--band", repr(band)), oracle_model(case), training, heldout, task["limit"])
        oracle = (known.facts or {}).get("relative_error")
    return {
        "id": case.id,
        "machine": case.machine,
        "group": case.group,
        "level": case.level,
        "planted": [{**asdict(plant), "omitted": sorted(plant.omitted)} for plant in case.planted],
        "true": case.true,
        "given": case.given,
        "answer": answer.facts,
        "error": answer.error,
        "seconds": round(answer.seconds, 2),
        "oracle": oracle,
    }


def kept(cases: Sequence[Case], setting: Setting, store: Path) -> list[dict[str, Any]]:
    """The records in a store, of those cases that were asked in this setting; the others are left out."""
    found = []
    wanted = {case.id for case in cases}
    for path in sorted(store.glob("*.json")):
        entry = json.loads(path.read_text(encoding="utf-8"))
        case = entry["task"]["case"]
        if case in wanted and entry["task"] == _task(case_of(case), setting):
            found.append(entry["result"])
    return sorted(found, key=lambda record: str(record["id"]))


def _task(case: Case, setting: Setting) -> dict[str, Any]:
    return {"case": case.id, "command": list(setting.command), "oracle": setting.oracle, "limit": setting.limit}
