"""Notebook display: LaTeX and MathML of the same equations."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

from symdyn.compiler import Compiled, load_robot
from symdyn.derive.equations import equations_of_motion
from symdyn.faces.mathml import mathml
from symdyn.faces.notebook import show
from symdyn.faces.report.equations import marked_equations


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


MATH = "{http://www.w3.org/1998/Math/MathML}math"


def test_a_large_arm_is_shown_step_by_step() -> None:
    equations = equations_of_motion(load_robot("panda"))
    html = show(equations)._repr_html_()
    page = ElementTree.fromstring(f"<div>{html}</div>".replace("&rsquo;", "'"))
    assert [b.text for b in page.iter("b")] == [f"joint{i}" for i in range(1, 8)]
    (folded,) = page.iter("details")
    headings = [h.text for h in folded.iter("h3")]
    assert headings[-1] == "Efforts"
    assert {f"Link {i} (joint{i})" for i in range(1, 8)} <= set(headings)
    assert "angular velocity" in html
    assert len(list(folded.iter(MATH))) > 500
    assert len(html) < 400_000  # a notebook keeps what it shows


def test_a_small_arm_has_nothing_folded_away() -> None:
    assert "<details" not in show(equations_of_motion(load_robot("two-link")))._repr_html_()


def test_the_report_of_a_large_arm_has_its_efforts() -> None:
    robot = load_robot("puma560")
    markup = marked_equations(robot, robot)
    assert markup.count('<div class="equation">') == 6
    assert markup.count("<details>") == 1
    assert "Link 3 (elbow)" in markup


@pytest.mark.parametrize(("name", "heading"), [("panda", "### Efforts"), ("two-link", "### Coefficients of the arm")])
def test_what_is_compiled_shows_itself_as_markdown(name: str, heading: str) -> None:
    robot = load_robot(name)
    text = Compiled(robot, equations_of_motion(robot), ())._repr_markdown_()
    assert text.startswith(f"## {name}\n")
    assert f"\n{heading}\n" in text
    assert text.count("$$") % 2 == 0
    assert text.count(r"\begin{aligned}") == text.count(r"\end{aligned}") == text.count("$$") // 2 > 2
    for line in text.split("\n"):
        assert len(line) < 400


def test_a_robot_shows_its_joints() -> None:
    text = load_robot("puma560")._repr_markdown_()
    assert text.startswith("**puma560**: Unimation Puma 560")
    assert "\n| waist | revolute | yes | viscous_friction, asymmetric_coulomb_friction |\n" in text


def test_representations_are_short_enough_to_print() -> None:
    robot = load_robot("panda")
    assert len(repr(Compiled(robot, equations_of_motion(robot), ()))) < 40_000
    assert "[robot]" not in repr(robot)  # the text of its file


def test_a_sign_behind_a_bracket_is_no_subtraction() -> None:
    assert '<mo form="prefix">&#x02212;</mo><mi>x</mi>' in mathml(r"a \left(- x\right)")
    assert '<mo form="prefix">&#x02212;' not in mathml(r"\left(y - x\right)")
