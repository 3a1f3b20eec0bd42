"""symdyn fleet: many diagnoses, one table; lists as TOML and CSV, patterns, and cases that cannot be diagnosed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from .command_line import PENDULUM, dry_friction, nothing, run, write_pair


@pytest.fixture(scope="module")
def shop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two machines, one with dry friction, and a recording that is none."""
    folder = tmp_path_factory.mktemp("shop")
    for name, hidden in (("dry", dry_friction), ("clean", nothing)):
        (folder / name).mkdir()
        write_pair(folder / name, hidden)
    (folder / "rod.toml").write_text(PENDULUM, encoding="utf-8")
    (folder / "short.csv").write_text("t,q,tau\n0,0,0\n", encoding="utf-8")
    (folder / "cases.csv").write_text(
        "name,model,recording,holdout\n"
        "one,rod.toml,dry/monday.csv,dry/tuesday.csv\n"
        "two,rod.toml,clean/monday.csv,clean/tuesday.csv\n"
        "three,rod.toml,short.csv,clean/tuesday.csv\n"
        "four,rod.toml,gone.csv,clean/tuesday.csv\n",
        encoding="utf-8",
    )
    return folder


def test_fleet_gives_a_verdict_for_every_case_and_goes_on_where_it_was(shop: Path, tmp_path: Path) -> None:
    store, out = tmp_path / "store", tmp_path / "verdicts.json"
    done = run("fleet", shop / "cases.csv", "-j", "2", "--resume", store, "--json", "-o", out)
    assert done.code == 1
    told = done.json()
    assert json.loads(out.read_text()) == told
    assert [case["name"] for case in told["cases"]] == ["one", "two", "three", "four"]
    assert [case["verdict"] for case in told["cases"]] == ["missing_physics", "complete", "bad_recording", "failed"]
    assert told["counts"] == {"bad_recording": 1, "complete": 1, "failed": 1, "missing_physics": 1}
    (finding,) = told["cases"][0]["findings"]
    assert finding["effect"] == "coulomb_friction"
    kept = {path: path.stat().st_mtime_ns for path in store.iterdir()}
    assert len(kept) == 4
    again = run("fleet", shop / "cases.csv", "-j", "1", "--resume", store)
    assert {path: path.stat().st_mtime_ns for path in store.iterdir()} == kept  # nothing was done again
    assert "Coulomb friction" in again.out  # a narrow terminal breaks the cell behind it
    assert "level = 0.3" in again.out
    assert "1 complete" in again.out


@pytest.mark.slow
def test_pattern_takes_every_recording_but_those_that_judge(shop: Path, tmp_path: Path) -> None:
    arguments = ("fleet", "--model", shop / "rod.toml", "--holdout", "tuesday.csv", f"{shop}/*/*.csv", "-j", "1")
    done = run(*arguments, "--json", "--resume", tmp_path)
    assert done.code == 0
    told = done.json()
    assert [Path(case["name"]).parts[-2:] for case in told["cases"]] == [("clean", "monday.csv"), ("dry", "monday.csv")]
    assert [case["verdict"] for case in told["cases"]] == ["complete", "missing_physics"]


@pytest.mark.slow
def test_list_as_toml_with_several_recordings_and_none_held_out(shop: Path, tmp_path: Path) -> None:
    (shop / "cases.toml").write_text(
        '[[case]]\nmodel = "rod.toml"\nrecording = ["dry/monday.csv", "dry/tuesday.csv"]\n', encoding="utf-8"
    )
    told = run("fleet", shop / "cases.toml", "-j", "1", "--json").json()
    (case,) = told["cases"]
    assert case["name"] == "dry/monday.csv, dry/tuesday.csv"
    assert [finding["effect"] for finding in case["findings"]] == ["coulomb_friction"]


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.toml", "[[case]]\nmodel = 3\nrecording = 'x'\n", "must be a text"),
        ("a.toml", "[[case]]\nmodel = 'x'\n", "`recording` is missing"),
        ("a.toml", "[[case]]\nmodel = 'x'\nrecording = 'y'\njudge = 'z'\n", "`judge` is no word"),
        ("a.toml", "case = 3\n", "[[case]] tables"),
        ("a.toml", "case = [\n", "no TOML"),
        ("a.csv", "model,recording\n", "holds no case"),
        ("a.csv", "model,recording\nx,y,z\n", "more columns"),
    ],
)
def test_list_that_is_none_is_refused(tmp_path: Path, name: str, text: str, words: str) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    done = run("fleet", tmp_path / name)
    assert done.code == 3
    assert words in done.err


def test_requests_that_do_not_go_together_are_refused(tmp_path: Path) -> None:
    assert run("fleet", "a.csv", "b.csv").code == 2
    assert run("fleet", "a.csv", "--holdout", "b.csv").code == 2
    assert run("fleet", tmp_path / "none.csv").code == 2
