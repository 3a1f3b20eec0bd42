"""Notebook display: LaTeX and MathML of the same equations."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

from symdyn.compiler import load_robot
from symdyn.derive.equations import equations_of_motion
from symdyn.faces.mathml import mathml
from symdyn.faces.notebook import show


def test_both_forms_of_the_two_link_arm() -> None:
    shown = show(equations_of_motion(load_robot("two-link")))
    latex, html = shown._repr_latex_(), shown._repr_html_()
    assert latex.count(r"\begin{aligned}") == latex.count(r"\end{aligned}") == 2
    assert r"\text{shoulder:}" in latex
    assert latex.count("$$") == 4
    page = ElementTree.fromstring(f"<div>{html}</div>")
    assert [b.text for b in page.iter("b")] == ["shoulder", "elbow"]
    assert len(list(page.iter("{http://www.w3.org/1998/Math/MathML}math"))) > 8
    assert repr(shown) == "<equations of motion of shoulder, elbow>"


def test_a_hidden_state_and_a_name_with_an_underscore() -> None:
    latex = show(equations_of_motion(load_robot("irb6-axis1")))._repr_latex_()
    assert r"\text{axis1.harmonic\_drive:}" in latex
    assert r"\dot{I}" in latex


def test_words_are_not_products_of_letters() -> None:
    assert "<mi>elbow</mi>" in mathml(r"F_{c,\mathrm{elbow}}")


@pytest.mark.parametrize("latex", [r"\text{<b>bold</b>}", r"\text{<}", "a & b"])
def test_nothing_but_mathml_gets_through(latex: str) -> None:
    with pytest.raises(ValueError, match="MathML"):
        mathml(latex)
