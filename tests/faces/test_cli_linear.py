"""The commands on linear models: frequency, sensitivity, reduce."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from symdyn.compiler import linearise, load_robot, robot_from_text
from symdyn.derive.linearize import without_nonsmooth
from symdyn.numeric.linear.cost import Band
from symdyn.numeric.linear.response import frequency_response

from .command_line import PENDULUM, run

LEFT_OUT = ["coulomb_friction at axis1.motor", "backlash at axis1.flexspline"]


@pytest.fixture
def rod(tmp_path: Path) -> Path:
    path = tmp_path / "rod.toml"
    path.write_text(PENDULUM, encoding="utf-8")
    return path


def test_frequency_of_the_seeds_drive() -> None:
    done = run("frequency", "irb6-axis1", "--points", "50", "--json")
    assert (done.code, done.err) == (0, "")
    facts = done.json()
    assert facts["left_out"] == LEFT_OUT
    assert facts["drift"] == {}
    assert (facts["input"], facts["output"], facts["unit"]) == ("axis1.motor.voltage", "axis1.tachometer.voltage", "1")
    pairs = [m for m in facts["modes"] if m["pole"][1] > 0]
    assert [m["frequency"] for m in pairs] == pytest.approx([15.17, 623.6, 1261.1], rel=5e-4)
    assert pairs[2]["name"] == "motor against tachometer"
    assert sum(pairs[1]["losses"].values()) == pytest.approx(pairs[1]["decay"])
    assert [e["kind"] for e in facts["extrema"]] == ["anti-resonance", "peak"] * 3
    assert len(facts["transfer_function"]["poles"]) == 8
    hertz = np.array(facts["response"]["hertz"])
    system = linearise(without_nonsmooth(load_robot("irb6-axis1"))).nominal
    assert facts["response"]["magnitude"] == pytest.approx(frequency_response(system, hertz).magnitude)
    shown = run("frequency", "irb6-axis1")
    assert shown.code == 0
    assert shown.err == f"linear part, without {', '.join(LEFT_OUT)}\n"
    assert "  peak at 15.461 Hz: 0.1548 (-16.2 dB)\n" in shown.out


def test_any_state_may_be_the_output_and_the_band_is_mine(tmp_path: Path) -> None:
    plot = tmp_path / "bode.svg"
    done = run("frequency", "irb6-axis1", "--output", "axis1.motor.current", "--from", "1", "--to", "100", "--points",
               "3", "--plot", plot, "--json")  # fmt: skip
    facts = done.json()
    assert facts["unit"] == "A / V"
    assert facts["response"]["hertz"] == pytest.approx([1.0, 10.0, 100.0])
    first = plot.read_bytes()
    assert ElementTree.fromstring(first).tag.endswith("svg")
    run("frequency", "irb6-axis1", "--output", "axis1.motor.current", "--from", "1", "--to", "100", "--points", "3",
        "--plot", plot)  # fmt: skip
    assert plot.read_bytes() == first
    assert b"axis1.motor.current" in first


def test_a_hanging_rod_swings_where_a_person_says_it_does(rod: Path) -> None:
    """m g c / (J + m c^2) below; turned up it falls; at the side it does not rest, and that is said."""
    facts = run("frequency", rod, "--points", "5", "--json").json()
    inertia = 0.04 + 2 * 0.25**2
    assert [m["frequency"] for m in facts["modes"]] == pytest.approx([np.sqrt(2 * 9.81 * 0.25 / inertia) / (2 * np.pi)])
    assert facts["modes"][0]["name"] == "pivot"
    up = run("frequency", rod, "--at", f"pivot.q={np.pi!r}", "--points", "5", "--json").json()
    assert [m["name"] for m in up["modes"]] == ["pivot slowing down", "pivot running away"]
    aside = run("frequency", rod, "--at", "pivot.q=1.0", "--points", "5")
    assert aside.code == 0
    assert "does not rest at this point: d pivot.qd/dt = -25." in aside.err
    torque = float(2 * 9.81 * 0.25 * np.sin(1.0))
    held = run("frequency", rod, "--at", "pivot.q=1.0", "--at", f"pivot.effort={torque!r}", "--points", "5")
    assert held.err == ""


def test_sensitivity_of_the_seeds_drive(tmp_path: Path) -> None:
    plot = tmp_path / "c_3.svg"
    done = run(
        "sensitivity",
        "irb6-axis1",
        "-p",
        "c_3",
        "-p",
        "d_7",
        "--factor",
        "2",
        "--points",
        "20",
        "--plot",
        plot,
        "--json",
    )
    assert (done.code, done.err) == (0, "")
    facts = done.json()
    assert facts["unused"] == ["T_f", "S"]
    assert set(facts["local"]) == {"c_3", "d_7"}
    mode_1 = next(i for i, m in enumerate(facts["modes"]) if m["pole"][1] > 0)
    assert facts["local"]["c_3"]["frequency"][mode_1] == pytest.approx(0.506, abs=1e-3)
    assert facts["local"]["c_3"]["frequency"][0] is None  # the pole at the origin has no logarithm
    assert [(v["parameter"], v["factor"]) for v in facts["one_at_a_time"]] == [("c_3", 2.0)]
    assert b"c_3" in plot.read_bytes()
    shown = run("sensitivity", "irb6-axis1", "--points", "20", "--plot", tmp_path / "all.svg")
    assert shown.code == 0
    assert "not in the linear model: T_f, S\n" in shown.err
    assert "mode 3: motor against tachometer, 1261.1 Hz" in shown.out
    assert b"K_Et" in (tmp_path / "all.svg").read_bytes()


@pytest.mark.parametrize(("method", "samples", "models"), [("morris", 2, 2 * 3), ("sobol", 4, 4 * 4)])
def test_global_sensitivity(method: str, samples: int, models: int) -> None:
    arguments = ("sensitivity", "irb6-axis1", "--global", method, "--samples", str(samples), "-p", "c_3", "-p", "J_4")
    facts = run(*arguments, "--seed", "3", "--json").json()
    assert (facts["method"], facts["evaluations"], facts["seed"]) == (method, models, 3)
    assert facts["ranges"]["c_3"] == pytest.approx([1.152, 1.728])
    rows = facts["table"]["frequency: axis1 against harmonic_drive, motor and tachometer"]
    assert {row["parameter"] for row in rows} == {"c_3", "J_4"}
    assert run(*arguments, "--seed", "3", "--json").json() == facts
    shown = run(*arguments)
    assert shown.code == 0
    assert f"{models} models, parameters within 20 %" in shown.out


def test_a_parameter_that_is_zero_has_no_range() -> None:
    done = run("sensitivity", "irb6-axis1", "--global", "morris", "-p", "d_7")
    assert (done.code, done.out) == (3, "")
    assert "SD307: there is no parameter to vary" in done.err


def test_reduce_finds_the_papers_lump_and_writes_the_file(tmp_path: Path) -> None:
    path = tmp_path / "reduced.toml"
    done = run("reduce", "irb6-axis1", "--from", "0.1", "--to", "100", "--out", path, "--json")
    assert (done.code, done.err) == (0, "")
    facts = done.json()
    first = facts["steps"][0]
    assert first["is"] == "d_5' = d_4 + d_5 + d_6 + d_7"
    assert first["alone"]["worst"] < 1e-3
    assert facts["order"] == {"full": 9, "reduced": 4}
    assert facts["values"]["d_5"] == pytest.approx(788e-6)
    before, after = load_robot("irb6-axis1"), robot_from_text(path.read_text(encoding="utf-8"), "reduced.toml")
    values = {p.name: p.value for p in after.parameters}
    assert values == {p.name: facts["values"].get(p.name, p.value) for p in before.parameters}
    assert path.read_text(encoding="utf-8").startswith("# First axis of an ASEA IRb6")
    hertz = Band(0.1, 100.0).hertz()
    full, small = (frequency_response(linearise(without_nonsmooth(r)).nominal, hertz).values for r in (before, after))
    assert np.abs(small / full - 1).max() == pytest.approx(facts["file_cost"]["worst"], rel=1e-6)


def test_a_step_that_no_file_may_hold_is_left_out_of_it(tmp_path: Path) -> None:
    """A rotor of almost no inertia: the gear ratio at zero costs nothing, and is no gear."""
    model, out = tmp_path / "geared.toml", tmp_path / "out.toml"
    rotor = '{ name = "motor", inertia = "1e-9 kg m^2", fixed_to_joint = true }'
    drive = f"[joint.drive]\nratio = 5\nrotors = [{rotor}]\n\n[recording]"
    model.write_text(PENDULUM.replace("[recording]", drive, 1), encoding="utf-8")
    facts = run("reduce", model, "--from", "0.1", "--to", "10", "--out", out, "--json").json()
    assert "pivot_drive_ratio = 0" in [step["is"] for step in facts["steps"]]
    (reason,) = facts["refused"]
    assert reason.startswith("pivot_drive_ratio = 0: SD231: ")
    robot = robot_from_text(out.read_text(encoding="utf-8"), "out.toml")
    values = {p.name: p.value for p in robot.parameters}
    assert values["pivot_drive_ratio"] == 5
    kept = {name: value for name, value in facts["values"].items() if name != "pivot_drive_ratio"}
    assert {name: values.get(name, 0.0) for name in kept} == kept  # a literal zero is no parameter any more
    assert "not in the file: pivot_drive_ratio = 0" in run("reduce", model, "--to", "10", "--out", out).err


def test_reduce_for_people(tmp_path: Path) -> None:
    plot = tmp_path / "reduced.svg"
    done = run("reduce", "irb6-axis1", "--to", "100", "--signal", "white", "--plot", plot)
    assert done.code == 0
    assert b"4 states" in plot.read_bytes()
    assert "9 states become 4, 19 parameters 9" in done.out
    assert "d_4, d_5, d_6, d_7 act as one" in done.out
    assert "not in the linear model: T_f, S" in done.err


def test_of_a_rod_only_the_distance_of_its_mass_matters(rod: Path) -> None:
    """The DH length and the place of the mass behind it act as their sum, exactly; there is nothing else to lose."""
    facts = run("reduce", rod, "--from", "0.1", "--to", "10", "--json").json()
    (step,) = facts["steps"]
    assert step["members"] == ["pivot_dh_a", "pivot_com_x"]
    assert step["alone"]["worst"] < 1e-12
    assert facts["order"] == {"full": 2, "reduced": 2}
    assert run("reduce", rod).code == 0


def test_global_sensitivity_is_the_same_whoever_does_the_work(tmp_path: Path) -> None:
    arguments = ("sensitivity", "irb6-axis1", "--global", "morris", "--samples", "4", "--json")
    alone = run(*arguments)
    spread = run(*arguments, "--jobs", "2", "--resume", tmp_path)
    assert spread.json() == alone.json()
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    assert len(kept) >= 2  # lots of models, the same whatever the number of processes
    assert run(*arguments, "--resume", tmp_path).json() == alone.json()
    assert {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()} == kept
