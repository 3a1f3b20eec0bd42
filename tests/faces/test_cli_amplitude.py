"""`symdyn frequency --amplitude`: what friction does to a response, by stepped sines and multisines."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from .command_line import run

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

[[effect]]
type = "coulomb_friction"
at = "slide"
level = 3.0

[[effect]]
type = "viscous_friction"
at = "slide"
coefficient = 0.5
"""
BAND = ("--from", "0.2", "--to", "5")


@pytest.fixture
def slider(tmp_path: Path) -> Path:
    path = tmp_path / "slider.toml"
    path.write_text(SLIDER, encoding="utf-8")
    return path


@pytest.mark.slow  # a sweep of a compiled machine by the command; the response itself has quick tests
def test_a_stepped_sine_shows_less_than_the_linear_part_and_odd_harmonics(slider: Path) -> None:
    stepped = ("frequency", slider, "--amplitude", "9", *BAND, "--points", "3", "-y", "slide.qd")
    done = run(*stepped, "--json")
    assert (done.code, done.err) == (0, "")
    facts = done.json()
    assert (facts["input"], facts["output"], facts["unit"]) == ("slide.effort", "slide.qd", "m/s / N")
    assert (facts["method"], facts["amplitude"], facts["settled"]) == ("stepped", 9.0, [True] * 3)
    hertz = np.array(facts["hertz"])
    assert hertz == pytest.approx([0.2, 1.0, 5.0])
    assert facts["linear_magnitude"] == pytest.approx(1 / np.abs(0.5 + 4j * np.pi * hertz))
    assert np.all(np.array(facts["magnitude"]) < facts["linear_magnitude"])
    assert min(facts["odd"]) > 0.01
    assert max(facts["even"]) < 1e-9
    shown = run(*stepped)
    assert (shown.code, shown.err) == (0, "")
    assert shown.out.startswith("slide.effort to slide.qd, m/s / N, amplitude 9:\n")
    (row,) = [line for line in shown.out.splitlines() if line.startswith("0.2 ")]
    assert f"{100 * facts['odd'][0]:.3g} %" in row
    assert "0 %" in row.split("│")[6]


@pytest.mark.slow  # compiles a machine of its own
def test_what_friction_holds_has_no_response(slider: Path) -> None:
    done = run("frequency", slider, "--amplitude", "2.9", *BAND, "--points", "2", "-y", "slide.qd")
    assert done.code == 0
    assert "-inf" in done.out


@pytest.mark.slow
def test_a_multisine_gives_the_same_numbers_for_the_same_seed(slider: Path) -> None:
    asked = (
        "frequency",
        slider,
        "--amplitude",
        "9",
        "--method",
        "multisine",
        *BAND,
        "--points",
        "16",
        "-y",
        "slide.qd",
    )
    once, again, other = (run(*asked, "--seed", seed, "--json") for seed in ("1", "1", "2"))
    assert (once.code, once.err) == (0, "")
    assert once.out == again.out != other.out
    facts = once.json()
    assert facts["unit"] == "m/s / N"
    assert len(facts["odd"]["hertz"]) == len(facts["hertz"]) // 3 >= 2
    odd = np.array(facts["odd"]["hertz"]) / 0.2
    assert odd == pytest.approx(2 * np.round((odd - 1) / 2) + 1)
    assert np.array(facts["even"]["hertz"]) / 0.4 == pytest.approx(np.round(np.array(facts["even"]["hertz"]) / 0.4))
    assert max(facts["even"]["level"]) < 1e-3 * max(facts["odd"]["level"])
    assert min(facts["deviation"]) > 0.0
    shown = run(*asked, "--seed", "1", "--realisations", "1")
    assert "of 1 realisations" in shown.out
    assert re.search(r"odd distortion: [\d.]+ % of the output, r\.m\.s\. of \d lines", shown.out)


def test_a_point_that_never_repeats_is_marked(slider: Path) -> None:
    """A spring, and no damper: what starts with the sine stays."""
    spring = '[[effect]]\ntype = "linear_spring"\nat = "slide"\nstiffness = 18\n'
    slider.write_text(SLIDER.partition("[[effect]]")[0] + spring, encoding="utf-8")
    done = run("frequency", slider, "--amplitude", "1", "--from", "0.31", "--to", "0.77", "--points", "2")
    assert done.code == 0
    assert done.err == "* not periodic in the end: its numbers are those of one period\n"
    assert done.out.count(" *") == 2


@pytest.mark.parametrize("method", ["stepped", "multisine"])
def test_its_plot_is_the_same_every_time(method: str, slider: Path, tmp_path: Path) -> None:
    asked = ("frequency", slider, "--amplitude", "9", "--method", method, *BAND, "--points", "6", "-y", "slide.qd",
             "--plot", tmp_path / "plot.svg")  # fmt: skip
    assert run(*asked).code == 0
    first = (tmp_path / "plot.svg").read_bytes()
    assert ElementTree.fromstring(first).tag.endswith("svg")
    assert {"linear part", "amplitude 9"} <= set(re.findall(r">([^<>]+)</text>", first.decode()))
    assert run(*asked).code == 0
    assert (tmp_path / "plot.svg").read_bytes() == first


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--method", "stepped"), "SD302: --method stepped needs an --amplitude"),
        (("--amplitude", "0"), "SD302: --amplitude must be positive"),
        (("--amplitude", "nan"), "SD302: --amplitude must be positive"),
        (("--amplitude", "1", "--method", "chirp"), "SD302: --method chirp: choose one of stepped, multisine"),
        (("--amplitude", "1", "--points", "1"), "SD302: --points must be from 2 to 2000"),
        (("--amplitude", "1", "--realisations", "0"), "SD302: --realisations must be from 1"),
        (("--amplitude", "1", "--method", "multisine", "--from", "1", "--to", "1e5"), "SD302: a multisine from 1 to"),
        (("--amplitude", "1", "--input", "slide.force"), "SD305: no input `slide.force`"),
        (("--amplitude", "1", "--output", "slide.w"), "SD305: no output `slide.w`"),
        (("--amplitude", "1", "--at", "slide.w=1"), "SD305: --at slide.w=1: no such state or input"),
    ],
)
def test_what_cannot_be_measured_is_told(arguments: tuple[str, ...], told: str, slider: Path) -> None:
    done = run("frequency", slider, *arguments)
    assert (done.code, done.out) == (2, "")
    assert told in done.err
