"""docs/paper.md is what the code says: words exactly, numbers to what a machine's rounding may change."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from benchmarks.paper.page import FIGURES, page
from benchmarks.paper.study import Study, study

DOCS = Path(__file__).parent.parent / "docs"
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")


@pytest.fixture(scope="module")
def found() -> Study:
    return study()


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


def test_its_figures_are_there(found: Study) -> None:
    assert {path.name for path in (DOCS / "paper").iterdir()} == set(FIGURES)
    assert set(re.findall(r"\(paper/([\w.-]+)\)", page(found))) == set(FIGURES)


def test_a_figure_shows_what_it_says(found: Study) -> None:
    """Its curves as points of the drawing: the peaks of figure 12 lie where halving and doubling c_3 puts them."""
    written = (DOCS / "paper" / "figure-12.svg").read_text(encoding="utf-8")
    assert {"nominal", "c_3 × 0.5", "c_3 × 2"} <= set(re.findall(r">([^<>]+)</text>", written))
    assert written == FIGURES["figure-12.svg"](found)
