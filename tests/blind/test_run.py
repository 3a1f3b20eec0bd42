"""Runs: the tool sees three files and no truth, a record per case, what is on disk is not run again."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from benchmarks.blind.__main__ import chosen, main
from benchmarks.blind.cases import all_cases, recordings
from benchmarks.blind.plot import confusion_svg
from benchmarks.blind.report import facts
from benchmarks.blind.run import Setting, kept, run_all
from benchmarks.blind.score import score
from benchmarks.blind.summary import Scored, confusion, scored
from benchmarks.blind.tool import DIAGNOSE, ask
from symdyn.numeric.executor import Executor

FAKE = """
import json, os, sys
files = {name: open(name).read() for name in sorted(os.listdir("."))}
print(json.dumps({"verdict": "complete", "findings": [], "files": files, "arguments": sys.argv[1:]}))
"""
CASE = "two-link_single_coulomb@j1_middle_0"


def command(script: str) -> tuple[str, ...]:
    return (sys.executable, "-c", script, "{model}", "{training}", "--holdout", "{heldout}")


def test_the_tool_sees_the_model_and_two_recordings_alone() -> None:
    (case,) = chosen([], [], [], [CASE])
    (record,) = run_all([case], Setting(command(FAKE), False, 60.0), Executor(), lambda _: None)
    seen = record["answer"]["files"]
    assert set(seen) == {"model.toml", "a.csv", "b.csv"}
    assert record["answer"]["arguments"] == ["model.toml", "a.csv", "--holdout", "b.csv"]
    assert all("coulomb" not in text for text in seen.values())
    assert (seen["a.csv"], seen["b.csv"]) == recordings(case)  # drawn from the name of the case alone
    assert seen["a.csv"] != seen["b.csv"]
    assert seen["a.csv"].splitlines()[0] == "t,x1,y1,x2,y2"
    assert len(seen["a.csv"].splitlines()) == 1 + 20 * 500
    assert record["planted"][0]["forms"][0]["coulomb_friction"]["level"] > 0


def test_a_run_goes_on_where_it_was(tmp_path: Path) -> None:
    cases = chosen(["two-link"], ["high"], ["null"], [])[:2]
    setting, told = Setting(command(FAKE), False, 60.0), []
    executor = Executor(store=tmp_path)
    run_all(cases[:1], setting, executor, told.append)
    (first,) = tmp_path.iterdir()
    before = first.stat().st_mtime_ns
    records = run_all(cases, setting, executor, told.append)
    assert first.stat().st_mtime_ns == before
    assert "step 1 of 2 cases" in told
    assert [record["id"] for record in records] == [case.id for case in cases]
    assert kept(cases, setting, tmp_path) == sorted(records, key=lambda record: record["id"])
    assert kept(cases[:1], setting, tmp_path) == records[:1]
    assert kept(cases, Setting(("other",), False, 60.0), tmp_path) == []
    plot = confusion_svg(confusion(scored(records)))
    assert plot == confusion_svg(confusion(scored(records)))


def test_a_tool_that_fails_or_hangs_is_no_answer() -> None:
    broken = ask(command("import sys; sys.exit('error: cannot')"), "", "", "", 60.0)
    assert (broken.facts, broken.error) == (None, "error: cannot")
    assert ask(command("print('[]')"), "", "", "", 60.0).error == "the answer is no JSON object"
    assert ask(command("import time; time.sleep(30)"), "", "", "", 0.5).error.startswith("no answer")


def test_the_command_line_lists_and_reports(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    part = ["--list", "--machines", "two-link,seed-drive", "--level", "low", "--groups", "unknown"]
    main(part)
    listed = capsys.readouterr().out.split()
    assert len(listed) == 21
    assert set(listed) < {case.id for case in all_cases()}
    main([*part, "--skip", "4", "--first", "3"])
    assert capsys.readouterr().out.split() == listed[4:7]
    main(["--cases", CASE, "--report-only", "--out", str(tmp_path)])
    assert capsys.readouterr().out.startswith("0 cases")
    assert json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))["cases"] == []
    page, scores = tmp_path / "page.md", tmp_path / "page.json"
    case = Scored(CASE, "two-link", "null", "middle", score([], {"verdict": "complete"}, None, 2.0))
    (tmp_path / "earlier.json").write_text(json.dumps(facts([case])), encoding="utf-8")
    earlier = ["--add", str(tmp_path / "earlier.json"), "--write", str(page)]
    main(["--cases", CASE, "--report-only", "--out", str(tmp_path), *earlier])
    assert "![confusion matrix](page.svg)" in page.read_text(encoding="utf-8")
    assert page.with_suffix(".svg").exists()
    assert json.loads(scores.read_text(encoding="utf-8"))["cases"][0]["id"] == CASE
    with pytest.raises(SystemExit):
        main(["--machines", "tractor"])


@pytest.mark.slow
def test_symdyn_names_coulomb_friction_on_a_plant_it_cannot_see() -> None:
    (case,) = chosen([], [], [], [CASE])
    (one,) = scored(run_all([case], Setting(DIAGNOSE, True, 600.0), Executor(), lambda _: None))
    (effect,) = one.score.effects
    assert (effect.named, effect.placed) == (True, True)
    assert one.score.heldout == pytest.approx(1.0, abs=0.1)
