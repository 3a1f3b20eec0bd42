"""The command line at large, and the commands that work on models: what each prints, writes and exits with."""

from __future__ import annotations

import ast
import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import sympy as sp

import symdyn
from symdyn.faces import cli
from symdyn.physics import catalogue
from symdyn.spec.machines import machine_names

from .command_line import GRAVITY, INERTIA, MOMENT, PENDULUM, Done, contents, nothing, run, torque, write_pair

COMMANDS = (
    "check",
    "derive",
    "base-parameters",
    "variants",
    "cost",
    "generate",
    "latex",
    "convert",
    "effects",
    "simulate",
    "frequency",
    "sensitivity",
    "reduce",
    "identify",
    "diagnose",
    "experiment",
    "profile",
    "fleet",
    "demo",
)


@pytest.fixture
def rod(tmp_path: Path) -> Path:
    path = tmp_path / "rod.toml"
    path.write_text(PENDULUM, encoding="utf-8")
    return path


def test_help_names_every_command() -> None:
    done = run("--help")
    assert (done.code, done.err) == (0, "")
    shown = [line.strip("│ ").split(" ")[0] for line in done.out.splitlines()]
    assert [word for word in shown if word in COMMANDS] == list(COMMANDS)
    commands = [info for info in cli.app.registered_commands if info.callback]
    assert [i.name or i.callback.__name__ for i in commands if i.callback and not i.hidden] == list(COMMANDS)
    assert [i.name for i in commands if i.hidden] == ["response"]  # another name of frequency


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("option", ["--help", "-h"])
def test_help_of_a_command(command: str, option: str) -> None:
    done = run(command, option)
    assert (done.code, done.err) == (0, "")
    assert f"symdyn {command}" in done.out


def test_version() -> None:
    assert run("--version") == Done(0, f"symdyn {symdyn.__version__}\n", "")


@pytest.mark.parametrize(
    "arguments",
    [
        ("nonsense",),
        ("check", "--nonsense"),
        ("derive",),
        ("latex", "two-link", "emps"),
        ("identify", "emps"),
        ("diagnose", "emps"),
        ("simulate", "emps", "--duration", "soon"),
        ("identify", "emps", "a.csv", "--band", "wide"),
        ("generate",),
        ("generate", "emps", "--all"),
        ("simulate", "emps", "--duration", "0"),
        ("simulate", "emps", "--duration", "nan"),
        ("simulate", "emps", "--step", "2"),
        ("simulate", "emps", "--step", "1e-12"),
        ("simulate", "emps", "--smoothing", "-1"),
        ("base-parameters",),
        ("frequency", "two-link", "--from", "0"),
        ("frequency", "two-link", "--from", "2", "--to", "1"),
        ("frequency", "two-link", "--to", "inf"),
        ("frequency", "two-link", "--points", "1"),
        ("frequency", "two-link", "--points", "1e9"),
        ("frequency", "two-link", "--at", "shoulder.q"),
        ("frequency", "two-link", "--at", "shoulder.q=nan"),
        ("frequency", "two-link", "--at", "wrist.q=1"),
        ("frequency", "two-link", "--input", "shoulder.voltage"),
        ("frequency", "two-link", "--output", "shoulder"),
        ("sensitivity", "two-link", "--parameter", "m_9"),
        ("sensitivity", "two-link", "--factor", "0"),
        ("sensitivity", "two-link", "--global", "lhs"),
        ("sensitivity", "two-link", "--global", "sobol", "--samples", "100"),
        ("sensitivity", "two-link", "--spread", "1"),
        ("sensitivity", "two-link", "--seed", "-1"),
        ("reduce", "two-link", "--error", "0"),
        ("reduce", "two-link", "--error", "nan"),
        ("reduce", "two-link", "--signal", "sine"),
        ("reduce", "two-link", "--to", "-1"),
        ("variants", "emps", "--states", "0"),
        ("variants", "emps", "--speed", "nan"),
        ("cost", "emps", "--function", "inverse"),
    ],
    ids=" ".join,
)
def test_wrong_usage_exits_2_and_does_nothing(
    arguments: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = run(*arguments)
    assert (done.code, done.out) == (2, "")
    assert "Error" in done.err or done.err.startswith("error: SD")
    assert contents(tmp_path) == {}


def test_as_a_process_of_its_own(tmp_path: Path) -> None:
    """Exit codes reach the shell, and help waits for no heavy import."""
    environment = os.environ | {"PYTHONPATH": str(Path(symdyn.__file__).parents[1])}

    def process(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", code, *arguments]
        return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)

    entry = "from symdyn.faces.cli import main; main()"
    heavy = "{'sympy', 'numba', 'pandas', 'scipy', 'matplotlib'} & set(sys.modules)"
    light = process(f"import sys, atexit; atexit.register(lambda: print('heavy:', {heavy})); {entry}", "--help")
    assert (light.returncode, light.stderr) == (0, "")
    assert light.stdout.endswith("heavy: set()\n")
    (tmp_path / "bad.toml").write_text("[robot", encoding="utf-8")
    bad = process(entry, "check", "bad.toml")
    assert (bad.returncode, bad.stdout) == (3, "")
    assert bad.stderr.startswith("error: bad.toml:1:7: SD001: ")
    module = [sys.executable, "-m", "symdyn", "check", "bad.toml"]
    same = subprocess.run(module, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (same.returncode, same.stdout, same.stderr) == (3, "", bad.stderr)
    shown = process(entry, "--debug", "check", "bad.toml")
    assert shown.returncode == 1
    assert "Traceback" in shown.stderr


def test_check_lists_the_machines() -> None:
    listed = run("check", "--json")
    assert (listed.code, listed.err) == (0, "")
    assert [machine["name"] for machine in listed.json()] == list(machine_names())
    assert all(machine["description"] for machine in listed.json())
    shown = run("check")
    assert (shown.code, shown.err) == (0, "")
    assert all(name in shown.out for name in machine_names())


def test_check_says_what_is_in_a_model_and_its_recordings(rod: Path, tmp_path: Path) -> None:
    first, second = write_pair(tmp_path, nothing)
    done = run("check", rod, first, second, "--json")
    assert (done.code, done.err) == (0, "")
    assert done.json() == {
        "robot": "swinging-rod",
        "joints": ["pivot"],
        "places": ["pivot"],
        "effects": [],
        "parameters": {
            "m": {"value": 2.0, "unit": "kg"},
            "J": {"value": 0.04, "unit": "kg m^2"},
            "gravity_x": {"value": 9.81, "unit": "m/s^2"},
            "pivot_dh_a": {"value": 0.5, "unit": "m"},
            "pivot_com_x": {"value": -0.25, "unit": "m"},
        },
        "warnings": [],
        "recordings": [
            {
                "name": name,
                "samples": 4000,
                "sample_time": pytest.approx(0.005),
                "segments": 1,
                "channels": [
                    {
                        "quantity": quantity,
                        "joint": "pivot",
                        "side": "link",
                        "quantisation_noise": pytest.approx(0, abs=1e-6),
                    }
                    for quantity in ("position", "effort")
                ],
            }
            for name in ("monday", "tuesday")
        ],
    }
    shown = run("check", rod, first)
    assert (shown.code, shown.err) == (0, "")
    assert "pivot (revolute)" in shown.out
    assert "monday: 4000 samples, 19.995 s at 200 Hz, 1 segment(s)\n" in shown.out


def test_derive_prints_the_equation_that_a_person_would(rod: Path) -> None:
    done = run("derive", rod, "--json")
    assert (done.code, done.err) == (0, "")
    facts = done.json()
    assert facts["coordinates"] == [{"name": "q_1", "place": "pivot", "unit": "rad"}]
    assert facts["steps"] == []
    left, right = facts["equations"]["pivot"].split(" = ")
    values = {"m": 2, "J": 0.04, "gravity_x": 9.81, "pivot_dh_a": 0.5, "pivot_com_x": -0.25}
    for q, qd, qdd in ((0.0, 0.0, 1.0), (0.7, -2.0, 0.0), (-2.5, 1.0, 3.0)):
        at = values | {"q_1": q, "qd_1": qd, "qdd_1": qdd, "u_1": torque(q, qdd)}
        assert abs(float((sp.sympify(left) - sp.sympify(right)).subs(at))) < 1e-12
    shown = run("derive", rod)
    assert (shown.code, shown.err) == (0, "")
    assert shown.out == f"q_1: pivot [rad]\n\npivot:\n  {facts['equations']['pivot']}\n"


def test_derive_shows_the_steps_when_asked(rod: Path) -> None:
    steps = run("derive", rod, "--steps", "--json").json()["steps"]
    assert steps
    assert all(set(step) == {"symbol", "expression", "origin"} for step in steps)
    shown = run("derive", rod, "--steps").out
    assert all(f"{s['symbol']} = {s['expression']}    # {s['origin']}\n" in shown for s in steps)


def test_generate_writes_kernel_equations_and_manifest_the_same_each_time(rod: Path, tmp_path: Path) -> None:
    once = run("generate", rod, "--out", tmp_path / "once", "--json")
    assert (once.code, once.err) == (0, "")
    names = ["kernel.py", "equations.tex", "manifest.json"]
    folder = tmp_path / "once" / "swinging_rod"
    assert once.json() == {"swinging-rod": [str(folder / name) for name in names]}
    files = contents(folder)
    assert sorted(files) == sorted(names)
    manifest = json.loads(files["manifest.json"])
    assert manifest["robot"] == "swinging-rod"
    assert manifest["model_sha256"] == hashlib.sha256(PENDULUM.encode()).hexdigest()
    assert manifest["files_sha256"] == {
        name: hashlib.sha256(files[name]).hexdigest() for name in ("kernel.py", "equations.tex")
    }
    assert {"inverse_dynamics", "forward_dynamics", "mass_matrix"} <= functions_of(files["kernel.py"])
    assert files["equations.tex"].startswith(rb"\documentclass")
    again = run("generate", rod, "--out", tmp_path / "again")
    assert (again.code, again.err) == (0, "generating swinging-rod\n")
    assert contents(tmp_path / "again" / "swinging_rod") == files


def functions_of(source: bytes) -> set[str]:
    return {node.name for node in ast.walk(ast.parse(source)) if isinstance(node, ast.FunctionDef)}


def test_one_bad_model_among_good_ones_stops_all(rod: Path, tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text(PENDULUM.replace('"2 kg"', '"2 m"'), encoding="utf-8")
    done = run("generate", rod, tmp_path / "bad.toml", "--out", tmp_path / "out")
    assert (done.code, done.out) == (3, "")
    assert not (tmp_path / "out").exists()


def test_latex_prints_what_it_writes(rod: Path, tmp_path: Path) -> None:
    printed = run("latex", rod)
    assert (printed.code, printed.err) == (0, "")
    assert printed.out.startswith("\\documentclass")
    assert printed.out.endswith("\\end{document}\n")
    assert r"\ddot{q}_{1}" in printed.out
    path = tmp_path / "new" / "rod.tex"
    assert run("latex", rod, "--out", path) == Done(0, "", f"written: {path}\n")
    assert contents(path.parent) == {"rod.tex": printed.out.encode()}


def test_what_cannot_be_written_is_told_and_leaves_nothing(rod: Path, tmp_path: Path) -> None:
    before = contents(tmp_path)
    for out in (tmp_path, rod / "rod.tex"):  # a folder; below a file
        done = run("latex", rod, "--out", out)
        assert (done.code, done.out) == (2, "")
        assert done.err.startswith("error: ")
    assert contents(tmp_path) == before
    assert not list(tmp_path.parent.glob(f".{tmp_path.name}*"))


def test_effects_lists_the_catalogue() -> None:
    done = run("effects", "--json")
    assert (done.code, done.err) == (0, "")
    rows = {row["effect"]: row for row in done.json()}
    assert list(rows) == list(catalogue())
    keys = {"effect", "title", "at", "parameters", "laws", "signature", "rivals", "builds_on", "proposable", "source"}
    assert all(row.keys() == keys for row in rows.values())
    viscous = rows["viscous_friction"]
    assert viscous["at"] == ["inertia", "joint", "shaft"]
    coefficient = viscous["parameters"]["coefficient"]
    assert coefficient["units"] == {"rotational": "N m s/rad", "translational": "N s/m"}
    assert (coefficient["null"], coefficient["lower"], coefficient["searched"]) == (0.0, 0.0, None)
    order = rows["torque_ripple"]["parameters"]["order"]
    assert (order["null"], order["searched"]) == (None, "angle_order")
    assert rows["stribeck_friction"]["builds_on"] == "coulomb_friction"
    assert viscous["laws"] == {"dissipation function": "coefficient*v**2/2"}
    assert rows["dahl_friction"]["laws"]["d elastic_deflection / dt"].startswith("-elastic_deflection*stiffness*Abs(v)")
    assert all(row["laws"] for row in rows.values())
    shown = run("effects")
    assert (shown.code, shown.err) == (0, "")
    assert all(row["signature"].split(" ")[0] in shown.out for row in rows.values())
    assert all(f"\n{name} " in shown.out for name in rows)  # in one piece: people copy them into a model
    assert rows["speed_loop"]["laws"]["handed on"] == "output"
    assert "clip(error_integral*integral + " in rows["speed_loop"]["laws"]["new waiting, at a sample"]
    assert "  level [N m or N]: size of the friction force; none at 0\n" in shown.out
    assert "  corrects: coulomb_friction\n" in shown.out


def test_simulate_writes_named_columns_that_conserve_energy(rod: Path, tmp_path: Path) -> None:
    path = tmp_path / "new" / "swing.csv"
    arguments = ("simulate", rod, "-t", "2", "--step", "0.01", "-x", "pivot.q=1.2")
    done = run(*arguments, "--out", path)
    assert (done.code, done.out) == (0, "")
    assert f"201 rows, 0 events located: {path}\n" in done.err
    table = pd.read_csv(path)
    assert list(table) == ["time [s]", "pivot.q [rad]", "pivot.qd [rad/s]", "pivot.effort [N m]"]
    np.testing.assert_allclose(table["time [s]"], 0.01 * np.arange(201), atol=1e-12)
    q, qd = table["pivot.q [rad]"], table["pivot.qd [rad/s]"]
    energy = 0.5 * INERTIA * qd**2 - MOMENT * GRAVITY * np.cos(q)
    np.testing.assert_allclose(energy, -MOMENT * GRAVITY * np.cos(1.2), atol=1e-6)
    assert qd.abs().max() > 3.0
    printed = run(*arguments)
    assert (printed.code, printed.out) == (0, path.read_text(encoding="utf-8"))
    facts = run(*arguments, "--json")
    assert (facts.code, facts.err) == (0, "")
    found = facts.json()
    assert found.pop("events") == []
    np.testing.assert_allclose(pd.DataFrame(found)[list(table)], table, rtol=1e-9, atol=1e-12)


def test_simulate_holds_the_input_that_is_given(rod: Path) -> None:
    held = f"pivot.effort={torque(0.5, 0.0):.17g}"
    facts = run("simulate", rod, "-t", "0.5", "--step", "0.1", "-x", "pivot.q=0.5", "-u", held, "--json").json()
    np.testing.assert_allclose(facts["pivot.q [rad]"], 6 * [0.5], atol=1e-9)
    np.testing.assert_allclose(facts["pivot.effort [N m]"], 6 * [torque(0.5, 0.0)], rtol=1e-14)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("-u", "elbow.effort=1"), "SD305: --input elbow.effort=1: no such name\n    known: pivot.effort"),
        (("-x", "pivot=1"), "SD305: --start pivot=1: no such name\n    known: pivot.q, pivot.qd"),
        (("-x", "pivot.q=__import__"), "'__import__' is no finite number"),
        (("-x", "pivot.q"), "'' is no finite number"),
        (("-u", "pivot.effort=nan"), "'nan' is no finite number"),
    ],
)
def test_simulate_refuses_what_it_cannot_hold(arguments: tuple[str, ...], told: str, rod: Path) -> None:
    path = rod.with_name("out.csv")
    done = run("simulate", rod, *arguments, "--out", path)
    assert (done.code, done.out) == (2, "")
    assert told in done.err
    assert not path.exists()


def test_simulate_names_the_parameters_without_a_value(rod: Path) -> None:
    rod.write_text(PENDULUM.replace('m = "2 kg"', 'm = { free = "kg" }'), encoding="utf-8")
    done = run("simulate", rod, "--out", rod.with_name("out.csv"))
    assert (done.code, done.out) == (2, "")
    assert done.err == f"error: {rod}:1:2: SD304: these parameters have no value: m\n"
    assert not rod.with_name("out.csv").exists()
