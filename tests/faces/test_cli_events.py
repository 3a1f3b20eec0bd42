"""`symdyn simulate`: inputs by shape, events in a file, what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from .command_line import PENDULUM, run

SLIDER = """\
[robot]
name = "slider"
gravity = [0, 0, 0]

[dh]
convention = "modified"
rows = [[0, "q", 0, 0]]

[[joint]]
name = "slide"
link = { mass = 2 }
"""
FRICTION = '[[effect]]\ntype = "coulomb_friction"\nat = "slide"\nlevel = 3.0\n'
EFFORT, Q, QD = "slide.effort [N]", "slide.q [m]", "slide.qd [m/s]"


@pytest.fixture
def slider(tmp_path: Path) -> Path:
    path = tmp_path / "slider.toml"
    path.write_text(SLIDER + FRICTION, encoding="utf-8")
    return path


def trapezoid(t: np.ndarray) -> np.ndarray:
    """One metre at 1 m/s and 2 m/s^2: half a second up, half a second even, half a second down."""
    return np.where(t < 0.5, t**2, np.where(t < 1.0, t - 0.25, 1.0 - np.clip(1.5 - t, 0.0, 1.0) ** 2))


def simulated(slider: Path, *arguments: str) -> pd.DataFrame:
    done = run("simulate", slider, "-t", "2", "--step", "0.01", *arguments, "--json")
    assert (done.code, done.err) == (0, "")
    facts = done.json()
    events = facts.pop("events")
    table = pd.DataFrame(facts)
    table.attrs["events"] = [(e["switch"], e["kind"], e["before"], e["after"]) for e in events]
    return table


def chirp(t: np.ndarray) -> np.ndarray:
    """From 0.5 to 3 Hz within 1.5 s, then 3 Hz."""
    swept = (0.5 + 0.5 * (2.5 / 1.5) * t) * t
    return 2 * np.sin(2 * np.pi * np.where(t < 1.5, swept, (0.5 + 0.5 * 2.5) * 1.5 + 3 * (t - 1.5)))


def multisine(t: np.ndarray) -> np.ndarray:
    return sum(np.sin(2 * np.pi * f * t - np.pi * k * (k + 1) / 4) for k, f in enumerate((0.5, 1.0, 1.5, 2.0)))


@pytest.mark.parametrize(
    ("shape", "values"),
    [
        ("2.5", lambda t: 2.5 + 0 * t),
        ("constant:-1", lambda t: -1 + 0 * t),
        ("step:2", lambda t: 2 + 0 * t),
        ("step:2,0.505", lambda t: 2.0 * (t > 0.505)),
        ("step:2,0.505,-1", lambda t: np.where(t > 0.505, 2.0, -1.0)),
        ("ramp:1.2", lambda t: 1.2 * t),
        ("ramp:1.2,0.5", lambda t: 1.2 * np.minimum(t, 0.5)),
        ("sine:2,0.7", lambda t: 2 * np.sin(1.4 * np.pi * t)),
        ("sine:2,0.7,0.3,0.5", lambda t: 0.5 + 2 * np.sin(1.4 * np.pi * t + 0.3)),
        ("trapezoid:1,1,2", trapezoid),
        ("chirp:2,0.5,3,1.5", chirp),
        ("chirp:2,3,0.5,4,-0.7", lambda t: -0.7 + 2 * np.sin(2 * np.pi * (3 - 0.3125 * t) * t)),
        ("multisine:2,0.5,2,4", multisine),
    ],
)  # fmt: skip
def test_an_input_has_the_shape_that_is_named(shape: str, values: object, slider: Path) -> None:
    """All weaker than friction, so that nothing moves and nothing happens."""
    assert callable(values)
    table = simulated(slider, "-u", f"slide.effort={shape}")
    time = table["time [s]"].to_numpy()
    np.testing.assert_allclose(table[EFFORT], values(time), atol=1e-12)
    assert np.all(table[[Q, QD]] == 0.0)
    assert table.attrs["events"] == []


def test_a_course_from_a_file(slider: Path, tmp_path: Path) -> None:
    """Held before the first row and behind the last, straight lines between; units in brackets count."""
    table = tmp_path / "course.csv"
    table.write_text("clock [ms],who,force [mN]\n500,a,1000\n1000,b,2500\n1500,c,-500\n", encoding="utf-8")
    found = simulated(slider, "-u", f"slide.effort=file:{table},clock [ms],force [mN]")
    time = found["time [s]"].to_numpy()
    np.testing.assert_allclose(found[EFFORT], np.interp(time, [0.5, 1.0, 1.5], [1.0, 2.5, -0.5]), atol=1e-12)


def test_what_was_simulated_is_a_course_again(slider: Path, tmp_path: Path) -> None:
    rows = tmp_path / "rows.csv"
    done = run("simulate", slider, "-t", "2", "--step", "0.01", "-u", "slide.effort=ramp:1.2", "--out", rows)
    assert done.code == 0
    found = simulated(slider, "-u", f"slide.effort=file:{rows}")
    np.testing.assert_allclose(found[EFFORT], 1.2 * found["time [s]"], atol=1e-9)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("time [s],slide.effort [N]\n0,1\n1,nan\n", "course.csv:3:2: SD504"),
        ("time [s],slide.effort [N]\n0,1\n2,1\n1,1\n", "course.csv:4:1: SD501: time runs backwards"),
        ("time [s],slide.effort [N]\n0,1\n1,1\n1,1\n", "course.csv:4:1: SD502"),
        ("time [s],slide.effort [N]\n0,1\n", "course.csv:2:1: SD508"),
        ("time [s],effort\n0,1\n1,1\n", "course.csv:1: SD510: no column 'slide.effort [N]'"),
    ],
)
def test_a_file_that_is_no_course_is_told_with_its_place(text: str, told: str, slider: Path, tmp_path: Path) -> None:
    table = tmp_path / "course.csv"
    table.write_text(text, encoding="utf-8")
    done = run("simulate", slider, "-u", f"slide.effort=file:{table}", "--out", tmp_path / "rows.csv")
    assert (done.code, done.out) == (3, "")
    assert told in done.err
    assert not (tmp_path / "rows.csv").exists()


def test_a_unit_of_something_else_is_told(slider: Path, tmp_path: Path) -> None:
    table = tmp_path / "course.csv"
    table.write_text("time [s],way [mm]\n0,1\n1,1\n", encoding="utf-8")
    done = run("simulate", slider, "-u", f"slide.effort=file:{table},time [s],way [mm]")
    assert (done.code, done.out) == (3, "")
    assert "SD506: column 'way [mm]'" in done.err


def test_a_step_beyond_friction_moves_it_as_newton_says(slider: Path) -> None:
    """2 x'' = 5 - 3 from half a second on."""
    table = simulated(slider, "-u", "slide.effort=step:5,0.5")
    since = np.clip(table["time [s]"] - 0.5, 0.0, None)
    np.testing.assert_allclose(table[Q], 0.5 * since**2, atol=1e-11)
    np.testing.assert_allclose(table[QD], since, atol=1e-11)
    assert table.attrs["events"] == [("slide", "friction", 0, 1)]


def test_events_go_to_a_file_of_their_own(slider: Path, tmp_path: Path) -> None:
    """Braked by 3 N from 2.4 m/s: it sticks at 1.6 s."""
    path, rows = tmp_path / "new" / "events.csv", tmp_path / "rows.csv"
    asked = ("simulate", slider, "-t", "2", "-x", "slide.qd=2.4", "--events", path, "--out", rows)
    done = run(*asked)
    assert (done.code, done.out) == (0, "")
    assert done.err.endswith(f"2001 rows, 1 events located: {rows}\n")
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "time,switch,kind,before,after"
    (event,) = [line.split(",") for line in lines[1:]]
    assert float(event[0]) == pytest.approx(1.6, abs=1e-10)
    assert event[1:] == ["slide", "friction", "1", "0"]
    first = path.read_bytes()
    assert run(*asked).code == 0
    assert path.read_bytes() == first


def test_a_file_without_events_has_its_header(slider: Path, tmp_path: Path) -> None:
    done = run("simulate", slider, "--events", tmp_path / "events.csv")
    assert done.code == 0
    assert done.err.startswith("simulating (the first time on a machine, ")
    assert (tmp_path / "events.csv").read_text(encoding="utf-8") == "time,switch,kind,before,after\n"


def test_smoothing_lets_creep_what_events_hold(slider: Path) -> None:
    held = simulated(slider, "-u", "slide.effort=2")
    creeping = simulated(slider, "-u", "slide.effort=2", "--smoothing", "0.01")
    assert np.all(held[Q] == 0.0)
    assert creeping[Q].iloc[-1] > 1e-3
    assert creeping.attrs["events"] == []


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("slide.effort=stp:1", "SD305: --input slide.effort=stp:1: no shape 'stp'"),
        ("slide.effort=step:", "'' is no finite number"),
        ("slide.effort=step:1,2,3,4", "4 numbers\n    step:VALUE[,TIME[,BEFORE]]"),
        ("slide.effort=sine:1", "1 numbers\n    sine:AMPLITUDE,HERTZ[,PHASE[,OFFSET]]"),
        ("slide.effort=sine:1,fast", "'fast' is no finite number"),
        ("slide.effort=ramp:inf", "'inf' is no finite number"),
        ("slide.effort=trapezoid:1,1", "2 numbers\n    trapezoid:DISTANCE,SPEED,ACCELERATION"),
        ("slide.effort=trapezoid:1,0,1", "speed must be positive"),
        ("slide.effort=trapezoid:1,1,-2", "acceleration must be positive"),
        ("slide.effort=chirp:1,1,9,0", "duration must be positive"),
        ("slide.effort=multisine:1,1,9,2.5", "lines must be a whole number"),
        ("slide.effort=file:", "which file, which columns?\n    file:PATH[,TIME COLUMN,COLUMN]"),
        ("slide.effort=file:a.csv,t", "which file, which columns?"),
        ("slide.force=step:1", "SD305: --input slide.force=step:1: no such name\n    known: slide.effort"),
    ],
)
def test_a_shape_that_is_none_is_told(given: str, told: str, slider: Path, tmp_path: Path) -> None:
    done = run("simulate", slider, "-u", given, "--events", tmp_path / "events.csv", "--out", tmp_path / "rows.csv")
    assert (done.code, done.out) == (2, "")
    assert "SD305" in done.err
    assert told in done.err
    assert [path.name for path in tmp_path.iterdir()] == ["slider.toml"]


@pytest.mark.parametrize("tolerance", ["0", "-1e-8", "1e-14", "0.1", "nan"])
def test_a_tolerance_out_of_range_is_refused(tolerance: str, tmp_path: Path) -> None:
    """A pendulum is not linear, so that it has one."""
    path = tmp_path / "rod.toml"
    path.write_text(PENDULUM, encoding="utf-8")
    done = run("simulate", path, "-x", "pivot.q=0.5", "--tolerance", tolerance, "--out", tmp_path / "rows.csv")
    assert done.code != 0
    assert "SD302" in done.err
    assert "choose one from 1e-13 to 1e-2" in done.err
    assert not (tmp_path / "rows.csv").exists()


def test_a_jump_without_a_mode_is_told_with_the_way_out(slider: Path) -> None:
    """Two clearances on one shaft: SD451, and --smoothing, or one clearance with their sum."""
    gap = '[[effect]]\ntype = "backlash"\nat = "slide.shaft"\nclearance = 0.01\n'
    drive = """[joint.drive]
rotors = [{ name = "motor", inertia = 0.2 }]
shafts = [{ name = "shaft", from = "motor", to = "joint", stiffness = 40, damping = 0.3 }]
"""
    slider.write_text(SLIDER + drive + gap + gap.replace("0.01", "0.02"), encoding="utf-8")
    done = run("simulate", slider, "--out", slider.with_name("rows.csv"))
    assert (done.code, done.out) == (3, "")
    assert "SD451" in done.err
    assert "declare one backlash with the sum" in done.err
    assert not slider.with_name("rows.csv").exists()
