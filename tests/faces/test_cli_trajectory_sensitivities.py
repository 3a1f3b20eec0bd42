"""symdyn simulate --sensitivities: derivatives of a trajectory as a file and as JSON."""

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
[parameters]
m = "2 kg"
F = "3 N"
[dh]
convention = "modified"
rows = [[0, "q", 0, 0]]
[[joint]]
name = "slide"
link = { mass = "m" }
[[effect]]
type = "coulomb_friction"
at = "slide"
level = "F"
"""


@pytest.fixture
def slider(tmp_path: Path) -> Path:
    path = tmp_path / "slider.toml"
    path.write_text(SLIDER, encoding="utf-8")
    return path


@pytest.mark.slow  # compiles the engine and its sensitivities
def test_a_block_that_slides_to_rest(slider: Path, tmp_path: Path) -> None:
    """x = v^2 m / (2 F) from the stop on, which the event passes on: dx/dm = v^2 / (2 F), dx/dF = - v^2 m / (2 F^2)."""
    arguments = ("simulate", slider, "-t", "2", "--step", "0.5", "-x", "slide.qd=1.5")
    written = run(*arguments, "--out", tmp_path / "x.csv", "--sensitivities", tmp_path / "s.csv")
    assert written.code == 0
    table = pd.read_csv(tmp_path / "s.csv")
    expected = {"d slide.q / d m [m/(kg)]": 1.5**2 / 6.0, "d slide.q / d F [m/(N)]": -(1.5**2) * 2.0 / 18.0}
    for name, value in expected.items():
        np.testing.assert_allclose(table[name][3:], value, rtol=1e-9)
    assert np.all(table["d slide.qd / d m [m/s/(kg)]"][3:] == 0.0)
    facts = run(*arguments, "--sensitivities", tmp_path / "s.csv", "-p", "F", "--json").json()["sensitivities"]
    assert list(facts) == ["time [s]", "d slide.q / d F [m/(N)]", "d slide.qd / d F [m/s/(N)]"]
    assert facts["d slide.q / d F [m/(N)]"] == pytest.approx(list(table["d slide.q / d F [m/(N)]"]))


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--sensitivities", "s.csv", "--smoothing", "1e-3"), "--sensitivities needs located events"),
        (("--parameter", "F"), "name a file for them"),
        (("--sensitivities", "s.csv", "-p", "nothing"), "no such parameter: nothing"),
    ],
)
def test_what_cannot_be_is_refused(slider: Path, options: tuple[str, ...], told: str) -> None:
    done = run("simulate", slider, *options)
    assert done.code != 0
    assert told in done.err
