"""The commands that work on recordings: channel maps, identify, diagnose to the written files, demo."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest

from symdyn.emit.kernel import load
from symdyn.numeric.findings import Verdict

from .command_line import (
    FRICTION,
    INERTIA,
    MOMENT,
    PENDULUM,
    Done,
    Hidden,
    bump,
    contents,
    dry_friction,
    nothing,
    recording_text,
    run,
    torque,
    write_pair,
)
from .fake_diagnosis import diagnosis, without_findings

MODEL, MAP = PENDULUM.split("[recording]\n")
MAP = f"[recording]\n{MAP}"
OUTPUTS = ("--report", "report.html", "--model-out", "robot.toml", "--generate", "kernel")


def outputs(folder: Path) -> tuple[str | Path, ...]:
    return tuple(x if x.startswith("-") else folder / x for x in OUTPUTS)


def diagnose(folder: Path, hidden: Hidden, *more: str | Path) -> Done:
    """The rod, which knows no friction, against a machine with something hidden in it."""
    model = folder / "rod.toml"
    model.write_text(PENDULUM, encoding="utf-8")
    training, heldout = write_pair(folder, hidden)
    return run("diagnose", model, training, "--holdout", heldout, *more)


@dataclass(frozen=True)
class Found:
    done: Done
    facts: Mapping[str, Any]
    folder: Path
    files: Mapping[str, bytes]


@pytest.fixture(scope="module")
def friction(tmp_path_factory: pytest.TempPathFactory) -> Found:
    """One diagnosis of the rod with dry friction, with all that it writes."""
    work = tmp_path_factory.mktemp("friction")
    done = diagnose(work, dry_friction, *outputs(work / "out"), "--json")
    return Found(done, done.json(), work / "out", contents(work / "out"))


def test_diagnose_finds_the_friction_that_was_left_out(friction: Found) -> None:
    assert friction.done.code == 0
    facts = friction.facts
    assert set(facts) >= {"verdict", "findings", "fit", "model", "remaining", "alarms", "band_hz", "recordings"}
    assert facts["verdict"] == "missing_physics"
    assert facts["recordings"] == {"training": "monday", "heldout": "tuesday"}
    (finding,) = facts["findings"]
    assert (finding["effect"], finding["place"]) == ("coulomb_friction", "pivot")
    assert list(finding["parameters"]) == ["level"]
    level = finding["parameters"]["level"]
    assert level["unit"] == "N m"
    assert 0 < level["se"] < 1e-2 * FRICTION
    assert abs(level["value"] - FRICTION) < min(5 * level["se"], 5e-3)
    before, after = facts["fit"]["before"], facts["fit"]["after"]
    assert before.keys() == after.keys() == {"training", "heldout"}
    assert after["heldout"] < 0.005 < 0.05 < before["heldout"]
    assert after["training"] < 0.005 < 0.05 < before["training"]
    assert finding["heldout_gain"] == pytest.approx(before["heldout"] - after["heldout"], abs=1e-5)
    assert not facts["remaining"]["structured"]


def test_diagnose_writes_the_model_with_the_effect_in_it(friction: Found) -> None:
    text = friction.files["robot.toml"].decode()
    (effect,) = tomllib.loads(text)["effect"]
    level = friction.facts["findings"][0]["parameters"]["level"]["value"]
    assert effect == {"type": "coulomb_friction", "at": "pivot", "level": f"{level:.8g} N m"}
    assert "# the base frame's x axis points down" in text
    checked = run("check", friction.folder / "robot.toml", "--json")
    assert (checked.code, checked.err) == (0, "")
    assert checked.json()["effects"] == [{"type": "coulomb_friction", "at": "pivot"}]


def test_diagnose_emits_the_kernel_of_that_model(friction: Found) -> None:
    manifest = json.loads(friction.files["kernel/manifest.json"])
    assert manifest["model_sha256"] == hashlib.sha256(friction.files["robot.toml"]).hexdigest()
    kernel = load(friction.folder / "kernel" / "kernel.py")
    level = friction.facts["findings"][0]["parameters"]["level"]["value"]
    q, qdd = np.array([0.7]), np.array([2.0])
    forth, back = (kernel.inverse_dynamics(q, np.array([qd]), qdd)[0] for qd in (1.0, -1.0))
    assert (forth - back) / 2 == pytest.approx(level, rel=1e-7)
    assert (forth + back) / 2 == pytest.approx(torque(0.7, 2.0), rel=5e-3)


def test_diagnose_writes_the_report_and_names_what_it_wrote(friction: Found) -> None:
    report = friction.files["report.html"].decode()
    assert report.lower().startswith("<!doctype html>")
    assert "The model lacked Coulomb friction at pivot." in report
    names = {"report.html", "robot.toml", *(f"kernel/{n}" for n in ("kernel.py", "equations.tex", "manifest.json"))}
    assert set(friction.files) == names
    for told in ("report: {}/report.html", "diagnosed model: {}/robot.toml", "kernel: {}/kernel"):
        assert told.format(friction.folder) + "\n" in friction.done.err


def test_diagnose_in_words_and_the_same_bytes_again(friction: Found, tmp_path: Path) -> None:
    done = diagnose(tmp_path, dry_friction, *outputs(tmp_path / "out"))
    assert done.code == 0
    assert done.out.startswith("The model lacked Coulomb friction at pivot. Held-out error fell from ")
    assert "level = 0.300" in done.out
    assert "found: Coulomb friction at pivot\n" in done.err
    assert contents(tmp_path / "out") == friction.files


@pytest.mark.parametrize(
    ("hidden", "verdict", "code", "words"),
    [
        (nothing, "complete", 0, "These recordings show nothing that the model lacks."),
        (bump, "unexplained", 1, "The model misses something that follows the position of pivot"),
    ],
)
def test_verdict_and_exit_code(hidden: Hidden, verdict: str, code: int, words: str, tmp_path: Path) -> None:
    done = diagnose(tmp_path, hidden, "--json", *outputs(tmp_path / "out"))
    facts = done.json()
    assert (done.code, facts["verdict"], facts["findings"]) == (code, verdict, [])
    assert facts["remaining"]["structured"] == (code == 1)
    files = contents(tmp_path / "out")
    assert words in files["report.html"].decode()
    assert "effect" not in tomllib.loads(files["robot.toml"].decode())
    assert "kernel/kernel.py" in files


@pytest.mark.parametrize(
    ("verdict", "code"), [(v, int(v is Verdict.UNEXPLAINED)) for v in Verdict if v is not Verdict.BAD_RECORDING]
)
def test_only_what_stays_unexplained_fails(verdict: Verdict, code: int, tmp_path: Path) -> None:
    found = verdict in (Verdict.MISSING_PHYSICS, Verdict.AMBIGUOUS)
    result = replace(diagnosis(), verdict=verdict) if found else without_findings(verdict)
    with mock.patch("symdyn.numeric.diagnose.diagnose", return_value=result):
        done = diagnose(tmp_path, nothing, "--json")
    assert (done.code, done.json()["verdict"]) == (code, verdict.value)
    assert set(contents(tmp_path)) == {"rod.toml", "monday.csv", "tuesday.csv"}


@pytest.mark.parametrize("more", [(), ("--thorough",)])
def test_thorough_lets_the_search_ask_everything(more: tuple[str, ...], tmp_path: Path) -> None:
    with mock.patch("symdyn.numeric.diagnose.diagnose", return_value=diagnosis()) as asked:
        diagnose(tmp_path, nothing, "--json", *more)
    assert asked.call_args.kwargs["thorough"] is bool(more)


def test_demo_diagnoses_what_ships_into_one_folder(tmp_path: Path) -> None:
    """Of the slow one below, what does not need the diagnosis."""
    result = diagnosis()
    with (
        mock.patch("symdyn.numeric.diagnose.diagnose", return_value=result) as made,
        mock.patch("symdyn.compiler.generate") as generate,
        mock.patch("symdyn.faces.report.write_report") as write_report,
    ):
        done = run("demo", "--out", tmp_path / "demo", "--json")
    robot, (training,), (heldout,) = made.call_args.args
    assert (robot.name, training.name, heldout.name) == ("two-link", "identification", "holdout")
    assert (training.warnings, heldout.warnings) == ((), ())
    assert (done.code, done.json()) == (0, result.to_json())
    generate.assert_called_once_with(result.diagnosed, tmp_path / "demo" / "kernel")
    write_report.assert_called_once_with(result, tmp_path / "demo" / "report.html")
    assert contents(tmp_path / "demo") == {"robot.toml": result.diagnosed.text.encode()}


@pytest.mark.slow
def test_demo_finds_what_its_plant_conceals(tmp_path: Path) -> None:
    done = run("demo", "--out", tmp_path, "--json")
    facts = done.json()
    assert (done.code, facts["verdict"]) == (0, "missing_physics")
    (finding,) = facts["findings"]
    assert (finding["effect"], finding["place"]) == ("lugre_friction", "elbow")
    truth = {"level": 0.25, "stiffness": 8.0, "excess": 0.12, "stribeck_velocity": 0.25}
    told = {name: finding["parameters"][name]["value"] for name in truth}
    assert told == pytest.approx(truth, rel=0.05)
    assert facts["fit"]["after"]["heldout"] < 0.005 < 0.05 < facts["fit"]["before"]["heldout"]
    types = [effect["type"] for effect in tomllib.loads((tmp_path / "robot.toml").read_text())["effect"]]
    assert types == ["viscous_friction", "viscous_friction", "lugre_friction"]


def test_identify_fits_what_the_motion_shows(tmp_path: Path) -> None:
    model = tmp_path / "rod.toml"
    model.write_text(PENDULUM.replace("2 kg", "1.5 kg").replace("0.04 kg", "0.09 kg"), encoding="utf-8")
    training, _ = write_pair(tmp_path, nothing)
    done = run("identify", model, training, "--json")
    assert (done.code, done.err) == (0, "")
    facts = done.json()
    assert set(facts) == {"parameters", "relative_error", "band_hz", "alarms"}
    assert facts["alarms"] == []
    fitted = {name: p["value"] for name, p in facts["parameters"].items()}
    units = {name: p["unit"] for name, p in facts["parameters"].items()}
    assert units == {"m": "kg", "J": "kg m^2", "pivot_com_x": "m"}
    c = 0.5 + fitted["pivot_com_x"]
    assert fitted["m"] * c == pytest.approx(MOMENT, rel=2e-3)
    assert fitted["J"] + fitted["m"] * c**2 == pytest.approx(INERTIA, rel=1e-2)
    assert 0 < facts["relative_error"] < 0.005
    shown = run("identify", model, training)
    assert shown.code == 0
    assert "swinging-rod fitted to monday" in shown.out
    assert f"below {facts['band_hz']:.3g} Hz" in shown.out
    assert set(contents(tmp_path)) == {"rod.toml", "monday.csv", "tuesday.csv"}


def test_the_map_given_comes_before_the_one_beside_and_that_before_the_models_own(tmp_path: Path) -> None:
    model, bare = tmp_path / "rod.toml", tmp_path / "bare.toml"
    model.write_text(PENDULUM, encoding="utf-8")
    bare.write_text(MODEL, encoding="utf-8")
    run_file, _ = write_pair(tmp_path, nothing, count=400)
    assert run("check", model, run_file).code == 0
    without = run("check", bare, run_file)
    assert without.code == 3
    assert without.err.startswith(f"error: {run_file}: SD512: ")
    beside = tmp_path / "monday.csv.toml"
    beside.write_text(MAP, encoding="utf-8")
    assert run("check", bare, run_file).code == 0
    beside.write_text(MAP.replace('"tau"', '"torque"'), encoding="utf-8")
    for either in (model, bare):
        misled = run("check", either, run_file)
        assert misled.code == 3
        assert misled.err.startswith(f"error: {run_file}:1: SD510: no column 'torque'\n")
    named = tmp_path / "named.toml"
    named.write_text(MAP, encoding="utf-8")
    assert run("check", model, run_file, "--map", named).code == 0


def test_a_short_gap_is_a_warning_not_an_error(tmp_path: Path) -> None:
    model, path = tmp_path / "rod.toml", tmp_path / "run.csv"
    model.write_text(PENDULUM, encoding="utf-8")
    lines = recording_text(1, nothing, 800).splitlines()
    path.write_text("\n".join(lines[:300] + lines[320:]), encoding="utf-8")
    done = run("check", model, path, "--json")
    assert done.code == 0
    assert done.err.startswith(f"warning: {path}:301:1: SD503: a gap of 0.105 s after 1.49 s ")
    (recording,) = done.json()["recordings"]
    assert (recording["samples"], recording["segments"]) == (780, 2)
    assert [warning.split(": ")[1] for warning in done.json()["warnings"]] == ["SD503"]


def test_what_two_variables_hide_together_is_not_called_complete(tmp_path: Path) -> None:
    done = diagnose(tmp_path, lambda q, qd: 1.5 * q * qd, "--json")
    facts = done.json()
    assert (done.code, facts["verdict"]) == (1, "unexplained")
    assert "position of pivot and speed of pivot" in facts["remaining"]["variable"]


def test_a_copy_of_the_training_recording_judges_nothing(tmp_path: Path) -> None:
    model = tmp_path / "rod.toml"
    model.write_text(PENDULUM, encoding="utf-8")
    first, second = write_pair(tmp_path, nothing)
    second.write_bytes(first.read_bytes())
    done = run("diagnose", model, first, "--holdout", second)
    assert done.code == 2
    assert "must not be the one that is fitted" in done.err


@pytest.mark.parametrize("band", ["0", "-1", "nan"])
def test_a_band_is_a_frequency(band: str, tmp_path: Path) -> None:
    model = tmp_path / "rod.toml"
    model.write_text(PENDULUM, encoding="utf-8")
    training, _ = write_pair(tmp_path, nothing)
    done = run("identify", model, training, "--band", band)
    assert done.code == 2
    assert "--band is a frequency in Hz" in done.err


def test_a_place_that_cannot_be_written_is_told_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "taken").mkdir()
    done = diagnose(tmp_path, nothing, "--report", tmp_path / "taken")
    assert (done.code, done.out) == (2, "")
    assert "taken" in done.err


def test_a_recording_that_fails_is_not_diagnosed_and_says_so_in_json(tmp_path: Path) -> None:
    model = tmp_path / "rod.toml"
    model.write_text(PENDULUM, encoding="utf-8")
    first, second = write_pair(tmp_path, nothing)
    lines = first.read_text(encoding="utf-8").splitlines()
    lines[10], lines[20] = lines[20], lines[10]
    first.write_text("\n".join(lines), encoding="utf-8")
    second.write_text(second.read_text(encoding="utf-8") + "1e9,nan,0\n", encoding="utf-8")
    done = run("diagnose", model, first, "--holdout", second, "--json", "--report", tmp_path / "report.html")
    facts = done.json()
    assert (done.code, facts["verdict"], facts["findings"], facts["located"]) == (3, "bad_recording", [], [])
    assert {p["code"] for p in facts["problems"]} == {"SD501", "SD504"}
    assert {p["where"]["file"] for p in facts["problems"]} == {str(first), str(second)}
    assert facts["fit"]["after"] == {"training": None, "heldout": None}
    assert "SD501" in done.err
    assert not (tmp_path / "report.html").exists()
    good = json.loads(json.dumps(diagnosis().to_json()))
    assert set(facts) == set(good)
    assert set(facts["remaining"]) == set(good["remaining"])
    assert set(facts["fit"]) == set(good["fit"])
    told = run("diagnose", model, first)
    assert told.code == 3
    assert told.out.startswith("The recording itself is wrong; nothing was diagnosed")


def test_a_file_that_is_not_there_is_no_bad_recording(tmp_path: Path) -> None:
    model = tmp_path / "rod.toml"
    model.write_text(PENDULUM, encoding="utf-8")
    done = run("diagnose", model, tmp_path / "none.csv", "--json")
    assert done.code in (2, 3)
    assert done.out == ""


@pytest.mark.slow
def test_diagnose_without_holdout_and_with_several_runs(tmp_path: Path) -> None:
    model = tmp_path / "rod.toml"
    model.write_text(PENDULUM, encoding="utf-8")
    first, second = write_pair(tmp_path, dry_friction)
    facts = run("diagnose", model, first, second, "--json").json()
    assert facts["verdict"] == "missing_physics"
    assert [f["effect"] for f in facts["findings"]] == ["coulomb_friction"]
    assert facts["recordings"] == {
        "training": "monday (fitted blocks), tuesday (fitted blocks)",
        "heldout": "monday (judging blocks), tuesday (judging blocks)",
    }
    twice = run("diagnose", model, first, first)
    assert (twice.code, "given twice" in twice.err) == (2, True)
