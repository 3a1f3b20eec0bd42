"""The fleet command: many diagnoses by the executor; one table and one JSON of verdicts."""

from __future__ import annotations

import glob
import hashlib
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from symdyn import compiler
from symdyn.base.errors import BadRecording, Problem, SymdynError, UsageError
from symdyn.base.files import check_writable, write_atomically
from symdyn.base.json_text import json_text
from symdyn.faces.console import err, out, print_json, print_table, status
from symdyn.faces.fleet_list import Case, read_cases
from symdyn.faces.recordings import open_recordings
from symdyn.faces.words import effect_title, percent, plain_number, with_unit
from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.executor import Executor, Task
from symdyn.numeric.findings import Verdict, bad_recording_json, problem_json
from symdyn.spec.urdf_chain import Chain

FAILED = "failed"  # the verdict of a case whose diagnosis could not be made


def run(
    given: Sequence[str],
    model: str | None,
    chain: Chain,
    holdout: str | None,
    channel_map: Path | None,
    executor: Executor,
    path: Path | None,
    json: bool,
) -> int:
    """Returns the exit code: 1 where a case could not be diagnosed."""
    if path is not None:
        check_writable(path)
    cases = _cases(given, model, holdout, channel_map)
    tasks = [asdict(case) | {"chain": asdict(chain), "content": _digests(case)} for case in cases]
    with status(json) as progress:
        progress(f"diagnosing {len(cases)} recordings")
        results = executor.map(diagnose_one, tasks, "diagnoses", progress)
    counts = Counter(str(result["verdict"]) for result in results)
    facts = {
        "counts": dict(sorted(counts.items())),
        "cases": [asdict(case) | result for case, result in zip(cases, results, strict=True)],
    }
    if path is not None:
        write_atomically(path, json_text(facts))
    if json:
        print_json(facts)
    else:
        _show(cases, results, counts)
        if path is not None:
            err.print(f"written: {path}", markup=False)
    return 1 if counts[FAILED] or counts[Verdict.BAD_RECORDING] else 0


def diagnose_one(task: Task, seed: int) -> dict[str, Any]:
    """One diagnosis as plain data: its JSON, or the problems that prevented it. The same for every seed."""
    channel_map = None if task["map"] is None else Path(task["map"])
    try:
        robot = compiler.load_robot(task["model"], Chain(**task["chain"]))
        fitted, held = ([Path(name) for name in task[which]] for which in ("recordings", "holdout"))
        try:
            training, judges = open_recordings(fitted, held, robot, channel_map)
            return diagnose(robot, training, judges or None).to_json()
        except BadRecording as bad:
            return bad_recording_json(robot.name, bad.problems)
    except SymdynError as error:
        return {"verdict": FAILED, "problems": [problem_json(problem) for problem in error.problems]}
    except OSError as error:
        problem = Problem("SD341", f"{error.strerror or error}: {error.filename or task['name']}")
        return {"verdict": FAILED, "problems": [problem_json(problem)]}


def _cases(given: Sequence[str], model: str | None, holdout: str | None, channel_map: Path | None) -> list[Case]:
    if model is None:
        if len(given) != 1 or holdout is not None or channel_map is not None:
            hint = "symdyn fleet CASES.toml; or symdyn fleet --model MODEL [--holdout FILE] RECORDING..."
            raise UsageError(Problem("SD341", "one list of cases, or recordings with --model", hint=hint))
        return read_cases(Path(given[0]))
    paths = [Path(name) for text in given for name in (sorted(glob.glob(text, recursive=True)) or [text])]
    known = str(Path(model).resolve()) if Path(model).is_file() else model
    found = []
    for path in dict.fromkeys(paths):
        judge = None if holdout is None else path.parent / holdout
        if judge is not None and not judge.is_file():
            judge = Path(str(holdout))
        if judge is not None and judge.resolve() == path.resolve():
            continue  # a pattern takes the held-out ones along
        where = None if channel_map is None else str(channel_map.resolve())
        judges = () if judge is None else (str(judge.resolve()),)
        found.append(Case(str(path), known, (str(path.resolve()),), judges, where))
    return found


def _digests(case: Case) -> dict[str, str]:
    """Of the files, so that a result belongs to what they hold; a bundled machine is known by its name."""
    found = {}
    for file in (case.model, *case.recordings, *case.holdout, case.map):
        if file is not None and Path(file).is_file():
            found[file] = hashlib.sha256(Path(file).read_bytes()).hexdigest()
            beside = Path(f"{file}.toml")
            if beside.is_file():
                found[str(beside)] = hashlib.sha256(beside.read_bytes()).hexdigest()
    return found


def _show(cases: Sequence[Case], results: Sequence[dict[str, Any]], counts: Counter[str]) -> None:
    rows = []
    for case, result in zip(cases, results, strict=True):
        if result["verdict"] in (FAILED, Verdict.BAD_RECORDING):
            rows.append((case.name, result["verdict"], "; ".join(p["message"] for p in result["problems"]), "", ""))
            continue
        before, after = (result["fit"][when]["heldout"] for when in ("before", "after"))
        found = "\n".join(_found(finding) for finding in result["findings"])
        rows.append((case.name, result["verdict"], found, percent(before), percent(after)))
    print_table("", ("case", "verdict", "found", "held out before", "after"), rows)
    out.print(", ".join(f"{number} {verdict}" for verdict, number in sorted(counts.items())), markup=False)


def _found(finding: dict[str, Any]) -> str:
    values = ", ".join(
        f"{name} = {with_unit(plain_number(e['value']), e['unit'])}" for name, e in finding["parameters"].items()
    )
    unsure = "?" if any(not rival.get("same_law") for rival in finding["rivals"]) else ""
    return f"{effect_title(finding['effect'])}{unsure} at {finding['place']}: {values}"
