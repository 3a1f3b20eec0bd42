"""docs/paper.md is what the code says: words exactly, numbers to what a machine's rounding may change."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.paper.page import FIGURES, page
from benchmarks.paper.study import Study, study
from symdyn.numeric.linear.response import frequency_response

DOCS = Path(__file__).parent.parent / "docs"
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")


@pytest.fixture(scope="module")
def found() -> Study:
    return study()


@pytest.mark.slow
def test_the_page_is_that_of_the_code(found: Study) -> None:
    written, now = (DOCS / "paper.md").read_text(encoding="utf-8"), page(found)
    assert NUMBER.sub("#", written) == NUMBER.sub("#", now), "run `make docs`"
    pairs = zip(NUMBER.findall(written), NUMBER.findall(now), strict=True)
    assert [(a, b) for a, b in pairs if float(a) != pytest.approx(float(b), rel=2e-3, abs=2e-3)] == []


def test_its_numbers_are_those_of_the_notes(found: Study) -> None:
    """Peaks, poles, damping and anti-resonances as an independent computation has them."""
    assert [e.frequency for e in found.peaks] == pytest.approx([15.46, 628.4, 1221.7], rel=4e-4)
    assert [m.frequency for m in found.swinging] == pytest.approx([15.17, 623.6, 1261.1], rel=5e-4)
    assert [m.damping for m in found.with_lost_damper()][1:] == pytest.approx([0.028, 0.018], abs=6e-4)
    assert any(s.what == "d_5" and len(s.members) == 4 for s in found.control.steps)


def test_its_figures_are_there() -> None:
    assert {path.name for path in (DOCS / "paper").iterdir()} == set(FIGURES)
    assert set(re.findall(r"\(paper/([\w.-]+)\)", (DOCS / "paper.md").read_text(encoding="utf-8"))) == set(FIGURES)


def test_a_figure_shows_what_it_says(found: Study) -> None:
    """Its curves as points of the drawing: the peaks of figure 12 lie where halving and doubling c_3 puts them."""
    written = (DOCS / "paper" / "figure-12.svg").read_text(encoding="utf-8")
    assert {"nominal", "c_3 × 0.5", "c_3 × 2"} <= set(re.findall(r">([^<>]+)</text>", written))
    assert written == FIGURES["figure-12.svg"](found)


@pytest.mark.slow
def test_friction_stops_the_motor_to_the_last_bit(found: Study) -> None:
    run = found.jumps.steps["friction and clearance"]
    last = [e for e in run.events if e.kind == "friction"][-1]
    assert (last.after, last.time) == (0, pytest.approx(0.6677, abs=1e-4))
    after = run.time > last.time
    motor, load = run.states[after, 1], run.states[after, 3]
    assert np.all(motor == motor[0])
    assert np.ptp(load) > 1e-3


@pytest.mark.slow
def test_what_is_measured_at_an_amplitude_nears_the_linear_part_and_is_odd(found: Study) -> None:
    """The larger the signal, the smaller the share of friction; even where the drive leans to one side, once."""
    changes = []
    for measured in found.jumps.measured.values():
        assert measured.settled.all()
        assert np.sum(measured.even > 1e-3) <= 1
        assert np.median(measured.even) < 1e-9
        linear = frequency_response(found.system, measured.hertz).values
        changes.append(np.median(np.abs(measured.values - linear) / np.abs(linear)))
    assert changes[0] > 2 * changes[1] > 4 * changes[2]


@pytest.mark.slow
def test_the_arm_hangs_on_its_drive_as_statics_say(found: Study) -> None:
    """At rest the flexspline holds m g l/2 cos q / N: c_3 (twist - S)."""
    jumps = found.jumps
    values = dict(zip(jumps.arm.kernel.parameters, jumps.arm.kernel.values, strict=True))
    x = dict(zip(jumps.arm.kernel.states, jumps.both.found.states[0], strict=True))
    twist = x["arm.harmonic_drive.q"] - values["N"] * x["arm.q"]
    torque = values["g"] * values["m"] * values["length"] / 2 * np.cos(x["arm.q"]) / values["N"]
    assert values["c_3"] * (twist - values["S"]) == pytest.approx(torque, rel=1e-4)
    assert values["N"] == pytest.approx(np.sqrt(values["m"] / 372e-6) / 2, rel=1e-6)
    assert x["arm.q"] == pytest.approx(0.6, abs=0.01)
