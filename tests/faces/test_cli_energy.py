"""symdyn simulate --energy: the book as a file and as JSON."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from .command_line import run

SLIDER = """
[robot]
name = "slider"
gravity = [0, 0, 0]
[dh]
convention = "modified"
rows = [[0, "q", 0, 0]]
[[joint]]
name = "slide"
link = { mass = 2 }
[[effect]]
type = "coulomb_friction"
at = "slide"
level = 3.0
"""


@pytest.fixture
def slider(tmp_path: Path) -> Path:
    path = tmp_path / "slider.toml"
    path.write_text(SLIDER, encoding="utf-8")
    return path


def test_the_book_of_a_block_that_slides_to_rest(slider: Path, tmp_path: Path) -> None:
    arguments = ("simulate", slider, "-t", "2", "--step", "0.5", "-x", "slide.qd=1.5", "--energy", tmp_path / "e.csv")
    done = run(*arguments, "--out", tmp_path / "x.csv")
    assert done.code == 0
    assert "energy accounted for but " in done.err
    book = pd.read_csv(tmp_path / "e.csv")
    columns = ["time", "supplied slide.effort", "dissipated slide.coulomb_friction", "stored links", "residual"]
    assert list(book) == [f"{name} [{'s' if name == 'time' else 'J'}]" for name in columns]
    states = pd.read_csv(tmp_path / "x.csv")
    np.testing.assert_allclose(book["dissipated slide.coulomb_friction [J]"], 3.0 * states["slide.q [m]"], rtol=1e-9)
    facts = run(*arguments, "--json").json()["energy"]
    assert facts["stored links [J]"] == pytest.approx(list(book["stored links [J]"]))
    assert facts["closure"] < 1e-12


def test_smoothed_jumps_have_no_book(slider: Path, tmp_path: Path) -> None:
    done = run("simulate", slider, "--smoothing", "1e-3", "--energy", tmp_path / "e.csv")
    assert (done.code, "--energy needs located events" in done.err) == (2, True)
