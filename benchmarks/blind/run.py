"""Runs cases: plant, ask, write the record of the case down; what is on disk is not run again."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from benchmarks.blind.cases import Case, model, oracle_model, recordings
from benchmarks.blind.tool import IDENTIFY, ask


@dataclass(frozen=True)
class Setting:
    """How the tool is asked; ``limit`` in s for each case."""

    command: tuple[str, ...]
    oracle: bool
    limit: float


def run_case(case: Case, setting: Setting) -> dict[str, Any]:
    """The record of one case: truth, answer, time, and the error that is left to one who knows the truth."""
    training, heldout = recordings(case)
    answer = ask(setting.command, model(case), training, heldout, setting.limit)
    band = (answer.facts or {}).get("band_hz")
    oracle = None
    if setting.oracle and band and all(plant.known for plant in case.planted):
        # The true structure, fitted to the held-out run itself: what is left is what no better answer could avoid.
        known = ask((*IDENTIFY, "--band", repr(band)), oracle_model(case), training, heldout, setting.limit)
        oracle = (known.facts or {}).get("relative_error")
    return {
        "id": case.id,
        "machine": case.machine,
        "group": case.group,
        "command": list(setting.command),
        "level": case.level,
        "seed": case.seed,
        "planted": [
            {**asdict(plant), "omitted": sorted(plant.omitted), "also_at": list(plant.also_at)}
            for plant in case.planted
        ],
        "true": case.true,
        "given": case.given,
        "answer": answer.facts,
        "error": answer.error,
        "seconds": round(answer.seconds, 2),
        "oracle": oracle,
    }


def run_all(cases: Sequence[Case], folder: Path, setting: Setting, jobs: int, progress: Callable[[str], None]) -> None:
    """Every case whose record is not in ``folder`` yet, ``jobs`` at a time."""
    folder.mkdir(parents=True, exist_ok=True)
    left = [case for case in cases if not _is_done(folder, case, setting)]
    progress(f"{len(cases)} cases, {len(cases) - len(left)} of them on disk")
    if jobs == 1:
        for count, case in enumerate(left, 1):
            progress(f"{count}/{len(left)} {_keep(folder, case, run_case(case, setting))}")
        return
    with ProcessPoolExecutor(jobs) as pool:
        waiting = {pool.submit(run_case, case, setting): case for case in left}
        for count, done in enumerate(as_completed(waiting), 1):
            progress(f"{count}/{len(left)} {_keep(folder, waiting[done], done.result())}")


def read_records(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))]


def _keep(folder: Path, case: Case, record: dict[str, Any]) -> str:
    """Written whole or not at all, so that a run that is killed leaves no half of a record."""
    path = _path(folder, case)
    part = path.with_suffix(".part")
    part.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    part.replace(path)
    answer = record["answer"]
    said = record["error"] if answer is None else f"{answer.get('verdict')}: {_said(answer)}"
    return f"{case.id} [{record['seconds']:.0f} s] {said}"


def _said(answer: dict[str, Any]) -> str:
    return ", ".join(f"{f['effect']} at {f['place']}" for f in answer.get("findings", ())) or "nothing found"


def _is_done(folder: Path, case: Case, setting: Setting) -> bool:
    """Whether this tool's answer is on disk."""
    path = _path(folder, case)
    return path.exists() and json.loads(path.read_text(encoding="utf-8"))["command"] == list(setting.command)


def _path(folder: Path, case: Case) -> Path:
    return folder / f"{case.id}.json"
