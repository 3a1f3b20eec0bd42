"""The commands about the rigid arm: base-parameters and variants."""

from __future__ import annotations

from pathlib import Path

import pytest

from symdyn.compiler import load_robot

from .command_line import run


def test_base_parameters_of_the_two_link() -> None:
    """The textbook's: two inertias about the axes, two first moments."""
    done = run("base-parameters", "two-link", "--json")
    assert (done.code, done.err) == (0, "")
    assert done.json() == [
        {"link": "shoulder", "entry": "xx + yy", "expression": "I_1 + l_1**2*m_2 + m_1*r_1**2", "unit": "kg m^2"},
        {"link": "shoulder", "entry": "x1", "expression": "l_1*m_2 + m_1*r_1", "unit": "kg m"},
        {"link": "elbow", "entry": "xx + yy", "expression": "I_2 + m_2*r_2**2", "unit": "kg m^2"},
        {"link": "elbow", "entry": "x1", "expression": "m_2*r_2", "unit": "kg m"},
    ]
    shown = run("base-parameters", "two-link")
    assert shown.code == 0
    assert shown.out.startswith("4 base parameters")
    assert "elbow x1 [kg m] = m_2*r_2" in shown.out


def test_variants_of_the_scara() -> None:
    done = run("variants", "scara", "--json", "--states", "20")
    assert (done.code, done.err) == (0, "")
    rows = {row["variant"]: row for row in done.json()}
    assert list(rows) == ["full", "no_coriolis", "diagonal_inertia", "gravity"]
    assert set(rows["full"]["error"].values()) == {0.0}
    assert rows["no_coriolis"]["error"]["quill"] == 0.0  # it slides along all axes
    assert rows["gravity"]["error"]["arm1"] == pytest.approx(1.0)
    assert rows["gravity"]["operations"]["multiplications"] < rows["full"]["operations"]["multiplications"]
    shown = run("variants", "scara", "--states", "20")
    assert shown.code == 0
    assert "error at quill" in shown.out


def test_a_free_parameter_is_refused(tmp_path: Path) -> None:
    free = tmp_path / "free.toml"
    text = load_robot("two-link").text
    line = next(line for line in text.split("\n") if line.startswith("m_1 ="))
    free.write_text(text.replace(line, 'm_1 = { free = "kg" }'), encoding="utf-8")
    done = run("variants", str(free))
    assert done.code == 2
    assert "SD304" in done.err
    assert "m_1" in done.err
    assert run("base-parameters", str(free)).code == 0
