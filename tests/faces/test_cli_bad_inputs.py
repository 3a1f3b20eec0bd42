"""Broken models and recordings at the command line: exit code 3, one clear message with the place, nothing written."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path

import pytest

from .command_line import PENDULUM, Done, contents, nothing, recording_text, run, write_pair

CODE = '__import__("os").system("touch canary")'

ARM = """\
[robot]
name = "arm"
gravity = [0, -9.81, 0]

[parameters]
m_1 = "2 kg"
m_2 = "1 kg"

[dh]
rows = [ ["q", 0, 0.5, 0],
         ["q", 0, 0.4, 0] ]

[[joint]]
name = "shoulder"
link = { mass = "m_1", com = [-0.25, 0, 0], inertia = { zz = 0.04 } }

[[joint]]
name = "elbow"
link = { mass = "m_2", com = [-0.2, 0, 0], inertia = { zz = "0.02 kg m^2" } }

[[effect]]
type = "viscous_friction"
at = "elbow"
coefficient = 0.1
"""

# what is replaced, by what, where that is told (line:column), the code, a piece of what is told
BAD_MODELS = {
    "unknown key": ('mass = "m_1"', 'mas = "m_1"', "15:10", "SD104", "did you mean `mass`?"),
    "unknown table": ("[robot]", "[robots]", "1:2", "SD104", "did you mean `robot`?"),
    "wrong dimension": ('mass = "m_1"', 'mass = "5 Nm"', "15:17", "SD221", "dimension torque (Nm), expected mass (kg)"),
    "dimension of a product": ('zz = "0.02 kg m^2"', 'zz = "1/3 m_2"', "19:61", "SD221", "expected"),
    "unknown unit": ('mass = "m_1"', 'mass = "5 stone"', "15:17", "SD222", "`stone` is not a unit"),
    "nan": ('mass = "m_1"', "mass = nan", "15:17", "SD201", "finite"),
    "infinite": ("com = [-0.25", "com = [inf", "15:31", "SD201", "finite"),
    "negative mass": ('mass = "m_1"', "mass = -2", "15:17", "SD203", "must not be negative"),
    "negative parameter": ('m_1 = "2 kg"', 'm_1 = "-2 kg"', "15:17", "SD203", "mass is -2, must not be negative"),
    "negative inertia": ("zz = 0.04", "zz = -40", "15:8", "SD214", "mass matrix is negative about joint `shoulder`"),
    "joint's name is code": ('name = "shoulder"', f"name = '{CODE}'", "14:8", "SD101", "is not a name"),
    "robot's name is code": ('name = "arm"', f"name = '{CODE}'", "2:8", "SD101", "is not a robot's name"),
    "robot's name is a path": ('name = "arm"', 'name = "../../arm"', "2:8", "SD101", "is not a robot's name"),
    "parameter's name is code": ("m_2 =", f"'{CODE}' = 1\nm_2 =", "7:1", "SD101", "is not a name"),
    "number is code": ('zz = "0.02 kg m^2"', f"zz = '{CODE}'", "19:61", "SD222", "number unit"),
    "effect is code": ('type = "viscous_friction"', f"type = '{CODE}'", "22:8", "SD104", "no effect"),
    "angle is code": ('["q", 0, 0.4', f"['q + {CODE}', 0, 0.4", "11:11", "SD222", 'is not "number unit"'),
    "joint twice": ('name = "shoulder"', 'name = "elbow"', "18:8", "SD106", "arm.toml:14:8"),
    "joints alike": ('name = "shoulder"', 'name = "Elbow"', "18:8", "SD103", "arm.toml:14:8"),
    "parameter twice": ("m_2 =", 'm_1 = "3 kg"\nm_2 =', "7:1", "SD001", "is defined twice"),
    "too few rows": (',\n         ["q", 0, 0.4, 0]', "", "10:8", "SD105", "1 DH rows for 2 joints"),
    "too many rows": ("0.4, 0] ]", '0.4, 0], ["q", 0, 1, 0] ]', "10:8", "SD105", "3 DH rows for 2 joints"),
    "row too short": ('["q", 0, 0.4, 0]', '["q", 0, 0.4]', "11:10", "SD105", "four columns"),
    "no such place": ('at = "elbow"', 'at = "elbows"', "23:6", "SD104", "attaches to: shoulder, elbow"),
    "syntax": ("[dh]", "[dh", "9:4", "SD001", "not valid TOML"),
    "decimal comma": ("coefficient = 0.1", "coefficient = 0,1", "24:16", "SD001", "write a decimal point"),
}

# content, the code and its place in the file, a piece of what is told
UNREADABLE: dict[str, tuple[bytes, str, str]] = {
    "empty": (b"", ": SD107: ", "the file has no `robot`"),
    "comment only": (b"# a robot\n", ": SD107: ", "the file has no `robot`"),
    "binary": (b'[robot]\nname = "a\xff\x00\x01"', ":2:10: SD005: ", "not UTF-8"),
    "utf-16": (ARM.encode("utf-16"), ":1:1: SD005: ", "save it as UTF-8"),
    "nul": (b'[robot]\nname = "a\0b"', ":2:10: SD001: ", "not valid TOML"),
    "too deep": (b"x = " + b"[" * 3000, ":1:69: SD002: ", "nested deeper"),
    "too large": (b"#" * (1 << 20) + b"\n", ": SD004: ", "larger than 1 MiB"),
}


def commands(model: Path, folder: Path) -> list[tuple[str | Path, ...]]:
    """Every command that takes a model, told to write all that it can."""
    out = folder / "out"
    training, heldout = write_pair(folder, nothing, count=400)
    return [
        ("check", model, "--json"),
        ("derive", model, "--json"),
        ("generate", model, "--out", out),
        ("latex", model, "--out", out / "arm.tex"),
        ("simulate", model, "--out", out / "arm.csv"),
        ("frequency", model, "--plot", out / "arm.svg", "--json"),
        ("sensitivity", model, "--plot", out / "arm.svg", "--json"),
        ("reduce", model, "--out", out / "reduced.toml", "--json"),
        ("identify", model, training, "--json"),
        ("diagnose", model, training, "--holdout", heldout, *outputs(out)),
    ]


def outputs(out: Path) -> tuple[str | Path, ...]:
    return "--report", out / "report.html", "--model-out", out / "robot.toml", "--generate", out / "kernel", "--json"


def refusals(model: Path, folder: Path) -> set[Done]:
    """How every command ends on the model; none may leave anything behind."""
    all_commands = commands(model, folder)
    before = contents(folder)
    ends = {run(*command) for command in all_commands}
    assert contents(folder) == before
    return ends


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """So that a file made by code from an input, or by a default path, would lie where it is looked for."""
    monkeypatch.chdir(tmp_path)


def test_the_bad_models_start_from_a_good_one(tmp_path: Path) -> None:
    model = tmp_path / "arm.toml"
    model.write_text(ARM, encoding="utf-8")
    done = run("check", model)
    assert (done.code, done.err) == (0, "")


@pytest.mark.parametrize("case", BAD_MODELS)
def test_a_bad_model_is_refused_by_every_command(case: str, tmp_path: Path) -> None:
    old, new, place, code, told = BAD_MODELS[case]
    assert ARM.count(old) == 1
    model = tmp_path / "arm.toml"
    model.write_text(ARM.replace(old, new), encoding="utf-8")
    (done,) = refusals(model, tmp_path)
    assert (done.code, done.out) == (3, "")
    assert done.err.startswith(f"error: {model}:{place}: {code}: ")
    assert done.err.count("error: ") == 1
    assert told in done.err


@pytest.mark.parametrize("case", UNREADABLE)
def test_a_file_that_is_no_model_is_refused_by_every_command(case: str, tmp_path: Path) -> None:
    content, place, told = UNREADABLE[case]
    model = tmp_path / "arm.toml"
    model.write_bytes(content)
    (done,) = refusals(model, tmp_path)
    assert (done.code, done.out) == (3, "")
    assert done.err.startswith(f"error: {model}{place}")
    assert told in done.err
    assert "Traceback" not in done.err


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("missing.toml", "SD003: does not exist"),
        ("folder", "SD003: is a directory"),
        ("no-such-machine", "SD003: no file and no bundled machine is called 'no-such-machine'\n    bundled: emps, "),
    ],
)
def test_no_model_there_is_refused_by_every_command(name: str, told: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (done,) = refusals(Path(name), tmp_path)
    assert (done.code, done.out) == (3, "")
    assert done.err.startswith(f"error: {name}: {told}")


def test_all_that_is_wrong_is_told_at_once(tmp_path: Path) -> None:
    model = tmp_path / "arm.toml"
    model.write_text(ARM.replace('mass = "m_1"', "mass = nan").replace('"0.02 kg m^2"', '"2 s"'), encoding="utf-8")
    done = run("generate", model, "--out", tmp_path / "out")
    assert done.code == 3
    told = [line.split(": ")[1:3] for line in done.err.splitlines() if line.startswith("error: ")]
    assert told == [[f"{model}:15:17", "SD201"], [f"{model}:19:61", "SD221"]]


# --- recordings --------------------------------------------------------------------------------------


def good() -> str:
    return recording_text(3, nothing, 400)


def with_line(number: int, line: str) -> str:
    """The good table with one of its lines (1-based) replaced."""
    lines = good().splitlines()
    lines[number - 1] = line
    return "\n".join(lines) + "\n"


def swapped(first: int, second: int) -> str:
    lines = good().splitlines()
    lines[first - 1], lines[second - 1] = lines[second - 1], lines[first - 1]
    return "\n".join(lines) + "\n"


def clock_jump() -> str:
    """Ten seconds are missing after the 200th row."""
    header, *rows = good().splitlines()
    late = [f"{float(t) + 10:.9g},{rest}" for t, rest in (row.split(",", 1) for row in rows[200:])]
    return "\n".join([header, *rows[:200], *late])


def packed() -> bytes:
    return gzip.compress(good().encode(), mtime=0)


# content, place and code, a piece of what is told
BAD_RECORDINGS: dict[str, tuple[Callable[[], str | bytes], str, str]] = {
    "unsorted": (lambda: swapped(100, 300), ":101:1: SD501: ", "time runs backwards"),
    "time stands still": (lambda: with_line(50, good().splitlines()[48]), ":50:1: SD502: ", "repeats the time"),
    "most of it lost": (clock_jump, ":202:1: SD503: ", "1 gap of more than 5 steps"),
    "nan": (lambda: with_line(7, "0.025,1,nan"), ":7:3: SD504: ", "column 'tau' holds 'nan'"),
    "infinite": (lambda: with_line(7, "0.025,-inf,1"), ":7:2: SD504: ", "column 'q' holds '-inf'"),
    "text": (lambda: with_line(9, "0.035,off,1"), ":9:2: SD504: ", "column 'q' holds 'off'"),
    "code": (lambda: with_line(9, f"0.035,1,'{CODE}'"), ":9:3: SD504: ", "no finite number"),
    "empty cell": (lambda: with_line(9, "0.035,,1"), ":9:2: SD504: ", "an empty cell"),
    "column missing": (lambda: good().replace("tau", "torque", 1), ":1: SD510: ", "columns there: t, q, torque"),
    "decimal commas": (
        lambda: good().replace(",", ";").replace(".", ","),
        ":1: SD505: ",
        "separated by ';' and numbers have decimal commas\n    first turn ',' into '.', then turn ';' into ','",
    ),
    "semicolons": (lambda: good().replace(",", ";"), ":1: SD505: ", "turn ';' into ','"),
    "row too long": (lambda: with_line(12, "0.05,1,1,1"), ":12: SD505: ", "4 fields where the header has 3"),
    "row too short": (lambda: with_line(12, "0.05,1"), ":12: SD505: ", "2 fields where the header has 3"),
    "column twice": (lambda: good().replace("\n", ",0\n").replace(",0", ",q", 1), ":1:4: SD505: ", "named 'q'"),
    "empty": (lambda: "", ": SD505: ", "the file is empty"),
    "header only": (lambda: "t,q,tau\n", ":2: SD505: ", "a header and no rows"),
    "no header": (lambda: good().partition("\n")[2], ":1: SD505: ", "columns' names"),
    "too short": (lambda: "\n".join(good().splitlines()[:151]), ":151:1: SD508: ", "at least 200 are needed"),
    "binary": (lambda: good().encode() + b"\x00\x01", ":402: SD505: ", "NUL"),
    "picture": (lambda: b"\x89PNG\r\n\x1a\n" + bytes(range(128, 255)), ":1: SD505: ", "0x89 is no UTF-8"),
    "gzipped, not said": (packed, ":1: SD505: ", "it is no text"),
}

BAD_FILES: dict[str, tuple[str, Callable[[], bytes], str, str]] = {
    "gzip cut off": ("run.csv.gz", lambda: packed()[:-200], ": SD505: ", "cut off or damaged"),
    "gzip damaged": ("run.csv.gz", lambda: packed()[:40] + b"\xff" * 40, ": SD505: ", "cut off or damaged"),
    "not gzipped": ("run.csv.gz", lambda: good().encode(), ": SD505: ", "a plain table must end in .csv"),
    "unsorted inside": ("run.csv.gz", lambda: gzip.compress(swapped(100, 300).encode()), ":101:1: SD501: ", "sort"),
    "unknown kind": ("run.xlsx", lambda: b"PK\x03\x04", ": SD523: ", ".csv"),
}


@pytest.fixture
def rod(tmp_path: Path) -> Path:
    path = tmp_path / "rod.toml"
    path.write_text(PENDULUM, encoding="utf-8")
    return path


def assert_refused(rod: Path, bad: Path, place: str, told: str, verdict: bool = True) -> None:
    """Both as the recording that is fitted and as the one that judges; a file that is there gets a ``verdict``."""
    folder = rod.parent
    _, sound = write_pair(folder, nothing, count=400)
    before = contents(folder)
    for arguments in (
        ("diagnose", rod, bad, "--holdout", sound, *outputs(folder / "out")),
        ("diagnose", rod, sound, "--holdout", bad, *outputs(folder / "out")),
        ("identify", rod, bad, "--json"),
        ("check", rod, sound, bad, "--json"),
    ):
        done = run(*arguments)
        assert done.code == 3
        if verdict and arguments[0] == "diagnose":
            assert done.json()["verdict"] == "bad_recording"
        else:
            assert done.out == ""
        assert done.err.startswith(f"error: {bad}{place}")
        assert done.err.count("error: ") == 1
        assert told in done.err
    assert contents(folder) == before


def test_the_bad_recordings_start_from_a_good_one(rod: Path, tmp_path: Path) -> None:
    for name, content in (("run.csv", good().encode()), ("run.csv.gz", packed())):
        (tmp_path / name).write_bytes(content)
        done = run("check", rod, tmp_path / name)
        assert (done.code, done.err) == (0, "")


@pytest.mark.parametrize("case", BAD_RECORDINGS)
def test_a_bad_recording_is_refused(case: str, rod: Path, tmp_path: Path) -> None:
    content, place, told = BAD_RECORDINGS[case]
    made = content()
    bad = tmp_path / "run.csv"
    bad.write_bytes(made.encode() if isinstance(made, str) else made)
    assert_refused(rod, bad, place, told, verdict="SD510" not in place)


@pytest.mark.parametrize("case", BAD_FILES)
def test_a_bad_file_of_a_recording_is_refused(case: str, rod: Path, tmp_path: Path) -> None:
    name, content, place, told = BAD_FILES[case]
    (tmp_path / name).write_bytes(content())
    assert_refused(rod, tmp_path / name, place, told, verdict="SD523" not in place)


@pytest.mark.parametrize(("name", "told"), [("missing.csv", "No such file"), ("folder.csv", "directory")])
def test_no_recording_there_is_refused(name: str, told: str, rod: Path, tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    assert_refused(rod, tmp_path / name, ": SD513: cannot read the file: ", told, verdict=False)


@pytest.mark.parametrize(
    ("old", "new", "place", "told"),
    [
        ('unit = "rad"', 'unit = "furlong"', ":8:8: SD222: ", "not a unit"),
        ('unit = "rad"', 'unit = "kg"', ":8:8: SD221: ", "expected"),
        ('joint = "pivot"\nunit = "rad"', 'joint = "knee"\nunit = "rad"', ":7:9: SD104: ", "no joint `knee`"),
        ('quantity = "effort"', 'quantity = "force"', ":12:12: SD202: ", "effort"),
        ('column = "tau"', 'colum = "tau"', ":11:1: SD104: ", "did you mean `column`?"),
        (
            '[[recording.channel]]\ncolumn = "tau"',
            '[[recording.channel]\ncolumn = "tau"',
            ":10:20: SD001: ",
            "Expected ']]'",
        ),
    ],
)
def test_a_bad_channel_map_is_refused(old: str, new: str, place: str, told: str, rod: Path, tmp_path: Path) -> None:
    channels = PENDULUM[PENDULUM.index("[recording]") :]
    assert channels.count(old) == 1
    path = tmp_path / "map.toml"
    path.write_text(channels.replace(old, new), encoding="utf-8")
    training, heldout = write_pair(tmp_path, nothing, count=400)
    before = contents(tmp_path)
    done = run("diagnose", rod, training, "--holdout", heldout, "--map", path, *outputs(tmp_path / "out"))
    assert (done.code, done.out) == (3, "")
    assert done.err.startswith(f"error: {path}{place}")
    assert told in done.err
    assert contents(tmp_path) == before
