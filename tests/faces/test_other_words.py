"""Laws that are together one of another name are told as that, too: with its numbers, and as no rival."""

from __future__ import annotations

from dataclasses import replace

import pytest

from symdyn.compiler import robot_from_text
from symdyn.faces.report.sections import rivals_table
from symdyn.faces.words import same_law_words, verdict_words
from symdyn.numeric.findings import Estimate, Finding
from symdyn.numeric.other_words import in_other_words

from .fake_diagnosis import COULOMB, RIPPLE, diagnosis, two_link

LEVEL = COULOMB.parameters["level"].value


def finding(effect: str, **parameters: tuple[float, float]) -> Finding:
    units = {"offset": "N m", "preload": "N m", "stiffness": "N m/rad"}
    told = {name: Estimate(value, se, units[name]) for name, (value, se) in parameters.items()}
    return Finding(effect, effect.replace("_", " "), "shoulder", told, 0.05, 0.04, 1e-6, ())


OFFSET = finding("force_offset", offset=(0.1, 0.004))


def test_dry_friction_and_an_offset_are_friction_that_differs_by_direction() -> None:
    told = in_other_words(diagnosis(None, COULOMB, RIPPLE, OFFSET))
    dry, ripple, offset = told.findings
    assert ripple.same_as == ()
    for each, other in ((dry, "force_offset"), (offset, "coulomb_friction")):
        (same,) = each.same_as
        assert (same.effect, same.place, same.beside) == ("asymmetric_coulomb_friction", "shoulder", (other,))
        levels = same.parameters["level_positive"], same.parameters["level_negative"]
        assert [e.value for e in levels] == pytest.approx([LEVEL + 0.1, LEVEL - 0.1])
        assert [e.se for e in levels] == pytest.approx([(0.0091**2 + 0.004**2) ** 0.5] * 2)
        assert {e.unit for e in levels} == {"N m"}
    assert told.verdict is diagnosis(None, COULOMB).verdict
    assert "tell which" not in verdict_words(told)
    facts = told.to_json()["findings"][0]["rivals"]
    assert [(r["effect"], r["same_law"], r["p_value"]) for r in facts] == [("asymmetric_coulomb_friction", True, 1.0)]
    assert same_law_words(dry, dry.same_as[0]) == (
        "Coulomb friction and constant force offset at shoulder are in other words direction-asymmetric Coulomb "
        "friction: level_positive 0.5134 ± 0.0099 N m, level_negative 0.3134 ± 0.0099 N m"
    )
    page = str(rivals_table(told))
    assert "direction-asymmetric Coulomb friction in place of it and constant force offset" in page
    assert page.count("one law, in other words") == 1
    assert "not told apart" not in page


def test_a_preload_is_an_offset() -> None:
    told = in_other_words(
        diagnosis(None, COULOMB, finding("linear_spring", stiffness=(2.0, 0.1), preload=(-0.1, 0.004)))
    )
    (same,) = told.findings[0].same_as
    assert same.beside == ("linear_spring",)
    assert same.parameters["level_positive"].value == pytest.approx(LEVEL + 0.1)


def test_what_the_model_had_before_counts() -> None:
    robot = two_link()
    dry = '\n[[effect]]\ntype = "coulomb_friction"\nat = "shoulder"\nlevel = "0.4 N m"\n'
    told = in_other_words(diagnosis(robot_from_text(robot.text + dry, "two-link.toml"), OFFSET))
    (same,) = told.findings[0].same_as
    assert same.parameters["level_positive"].value == pytest.approx(0.5)
    assert same.parameters["level_positive"].se == pytest.approx(0.004)


@pytest.mark.parametrize(
    "beside",
    [
        replace(OFFSET, parameters={"offset": Estimate(0.5, 0.004, "N m")}),  # no friction pushes
        finding("linear_spring", stiffness=(2.0, 0.1), preload=(0.005, 0.004)),  # may be nothing
        replace(OFFSET, place="elbow"),
        RIPPLE,
    ],
)
def test_other_laws_are_none(beside: Finding) -> None:
    told = in_other_words(diagnosis(None, COULOMB, beside))
    assert all(each.same_as == () for each in told.findings)
