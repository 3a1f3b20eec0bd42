"""The report: one offline file, well formed, safe, the same every time, and nothing left out."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import matplotlib
import numpy as np
import pytest

from symdyn.compiler import robot_from_text
from symdyn.derive.equations import equations_of_motion
from symdyn.emit.latex import terms_with
from symdyn.faces.report import render_report, write_report
from symdyn.faces.report.plots import plots, position_units
from symdyn.faces.report.sections import (
    findings_table,
    joints_table,
    located_table,
    next_experiment_text,
    remaining_text,
    rivals_table,
)
from symdyn.faces.report.series import binned_mean, runs, thinned, worst_window
from symdyn.faces.report.specification import marked_specification
from symdyn.numeric.findings import Estimate, MissingForce, NextExperiment, Rival, Verdict
from tests.numeric.slide import SLIDE

from .fake_diagnosis import COULOMB, RIPPLE, diagnosis, two_link, with_findings, without_findings

HOSTILE = '<script>alert("x")</script>'
VOID = {"meta", "br"}


class Outline(HTMLParser):
    """Checks that tags are balanced and collects what the page holds."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str | None]] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += attrs

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


def outline(page: str) -> Outline:
    parser = Outline()
    parser.feed(page)
    parser.close()
    assert parser.open == []
    return parser


@pytest.fixture(scope="module")
def page() -> str:
    return render_report(diagnosis(None, RIPPLE, COULOMB))


def test_the_page_is_balanced_html(page: str) -> None:
    found = outline(page)
    assert page.startswith("<!DOCTYPE html>")
    assert found.tags.count("svg") == 5
    assert found.tags.count("h1") == 1


def test_nothing_is_fetched_and_nothing_runs(page: str) -> None:
    addresses = re.findall(r"https?://[^\"'\s<)]*", page)
    assert set(addresses) <= {
        "http://www.w3.org/2000/svg",
        "http://www.w3.org/1999/xlink",
        "http://www.w3.org/1998/Math/MathML",
    }
    found = outline(page)
    assert not {"script", "link", "img", "iframe", "object", "image"} & set(found.tags)
    assert not [name for name, _ in found.attributes if name.startswith("on") or name == "src"]
    references = [value for name, value in found.attributes if name in ("href", "xlink:href")]
    assert all(value is not None and value.startswith("#") for value in references)
    assert "@import" not in page
    assert set(re.findall(r"url\((.)", page)) <= {"#"}


def test_ids_are_unique_and_references_resolve(page: str) -> None:
    attributes = outline(page).attributes
    ids = [value for name, value in attributes if name == "id"]
    assert len(ids) == len(set(ids))
    assert set(re.findall(r"url\(#([^)]*)\)", page)) <= set(ids)
    assert {value[1:] for name, value in attributes if name in ("href", "xlink:href") and value} <= set(ids)


def test_same_diagnosis_same_bytes(tmp_path: Path, page: str) -> None:
    """Made again, and under other settings of matplotlib, the file is the same."""
    with matplotlib.rc_context({"font.size": 20, "lines.linewidth": 9, "svg.fonttype": "path", "axes.facecolor": "r"}):
        write_report(diagnosis(None, RIPPLE, COULOMB), tmp_path / "new" / "report.html")
    assert (tmp_path / "new" / "report.html").read_bytes() == page.encode()
    assert [p.name for p in (tmp_path / "new").iterdir()] == ["report.html"]


def test_verdict_findings_and_numbers_are_told(page: str) -> None:
    text = outline(page).text.replace("\N{NO-BREAK SPACE}", " ")
    assert "The model lacked torque ripple (cogging) at elbow and Coulomb friction at shoulder." in text
    for told in ("0.2255 ± 0.0041 N m", "0.2677 ± 0.0040 N m", "11 rad/rad", "0.4134 ± 0.0091 N m", "13 %", "4.1 %"):
        assert told in text
    assert "(1.152 ± 0.031) × 10−5 kg m2" in text
    assert text.count("not identifiable alone") == 1
    for told in ("p < 0.001", "p = 0.0021", "identification.csv.gz", "holdout.csv.gz", "0 to 10.4 Hz", "backlash at"):
        assert told in text


def test_a_diagnosis_without_findings() -> None:
    page = render_report(without_findings(Verdict.UNEXPLAINED))
    text = outline(page).text
    assert "No known effect lowers the held-out error" in text
    assert "It is structured: 62 % of its power follows the position of elbow" in text
    assert "term new" not in page
    assert "→" not in text


def test_noise_that_is_left_is_called_so() -> None:
    left = without_findings(Verdict.COMPLETE)
    assert "close to noise: only 4.0 % of its power follows the position of elbow" in remaining_text(left)
    nothing = replace(left, remaining=replace(left.remaining, share=0.0, variable=None))
    assert "It looks like noise" in remaining_text(nothing)


def test_rivals_are_named() -> None:
    unsure = replace(RIPPLE, rivals=(Rival("linear_spring", "elbow", 0.31),))
    told = replace(diagnosis(None, unsure), verdict=Verdict.AMBIGUOUS)
    table = outline(rivals_table(told)).text
    assert "torque ripple (cogging) at elbowlinear spring at elbowas wellnot told apart, p = 0.31" in table
    assert "linear spring at elbow11 % instead of 4.9 %told apart" in table
    assert "No motion has been designed" in next_experiment_text(told)


def test_nothing_that_came_near_is_said() -> None:
    assert "No other known effect came near" in rivals_table(diagnosis(None, COULOMB))
    assert "no finding to rival" in rivals_table(without_findings(Verdict.COMPLETE))


def test_the_next_experiment_is_told() -> None:
    between = (("torque_ripple", "elbow"), ("linear_spring", "elbow"))
    planned = NextExperiment(between, 38.25, "next.csv", "a slow turn of the elbow tells them apart")
    text = outline(next_experiment_text(replace(diagnosis(), next_experiment=planned))).text
    assert text == (
        "A slow turn of the elbow tells them apart. It is expected to tell torque ripple (cogging) at elbow "
        "from linear spring at elbow by 38.2 nats. It is in next.csv."
    )


def test_places_come_with_their_group_and_evidence() -> None:
    where = outline(located_table(diagnosis())).text
    assert "elbowor elbow.motorangle order 11, low speed312 nats" in where
    assert "413 nats" in outline(findings_table(diagnosis())).text
    assert "shows no structure" in located_table(replace(diagnosis(), located=()))


def test_the_noise_floor_stands_beside_the_errors() -> None:
    table = outline(joints_table(diagnosis())).text
    assert re.search(r"elbow.*3\.4 %", table)
    assert "would leave 3.2 %" in remaining_text(diagnosis())
    unknown = replace(diagnosis(), noise_floor=None)
    assert outline(joints_table(unknown)).text.count("not known") == 3
    assert "would leave" not in remaining_text(unknown)
    assert "noise of the sensors" in plots(diagnosis())
    assert "noise of the sensors" not in plots(replace(unknown, traces=replace(unknown.traces, noise=None)))


def test_hostile_text_stays_text() -> None:
    fine = diagnosis()
    robot = replace(fine.robot, name=HOSTILE, description=HOSTILE, text=f"# {HOSTILE}\n")
    bad = replace(
        fine,
        robot=robot,
        diagnosed=replace(fine.diagnosed, name=HOSTILE, description=HOSTILE, text=f"# {HOSTILE}\nnew = '{HOSTILE}'\n"),
        findings=(replace(RIPPLE, place=HOSTILE, title=HOSTILE, parameters={HOSTILE: Estimate(1.0, 0.1, HOSTILE)}),),
        model={HOSTILE: Estimate(1.0, None, HOSTILE)},
        alarms=(HOSTILE,),
        training=HOSTILE,
        heldout=HOSTILE,
        remaining=replace(fine.remaining, structured=True, share=0.5, variable=HOSTILE),
        traces=replace(fine.traces, effort_units=(HOSTILE, HOSTILE)),
    )
    page = render_report(bad)
    found = outline(page)
    assert "script" not in found.tags
    assert found.text.count(HOSTILE) > 10
    assert "<script" not in page.lower()


def test_new_terms_are_marked_and_only_those(page: str) -> None:
    terms = re.findall(r'<span class="term new">(.*?)</span>', page)
    assert len(terms) == 3  # friction, and the cosine and sine of the ripple
    assert ["elbow" in term for term in terms] == [False, True, True]
    given = two_link()
    diagnosed = with_findings(given, RIPPLE)
    names = {p.name for p in diagnosed.parameters} - {p.name for p in given.parameters}
    new = terms_with(equations_of_motion(diagnosed), names)
    assert len(new) == 2
    assert all("elbow" in term for term in new)
    assert terms_with(equations_of_motion(given), names) == frozenset()


def test_the_specification_is_shown_whole_with_new_lines_marked() -> None:
    given = two_link()
    diagnosed = with_findings(given, RIPPLE)
    markup = str(marked_specification(given, diagnosed))
    marked = re.findall(r"<ins>(.*?)</ins>", markup)
    assert "type = &#34;torque_ripple&#34;" in marked
    assert not [line for line in marked if "robot" in line]
    assert outline(markup).text == diagnosed.text


def test_a_short_recording_has_no_plots() -> None:
    shown = plots(diagnosis(samples=12))
    assert "too short for plots" in shown
    assert "<svg" not in shown


def test_a_recording_of_nothing_is_drawn() -> None:
    fine = diagnosis()
    still = np.zeros_like(fine.traces.effort)
    traces = replace(fine.traces, q=still, qd=still, effort=still, before=still, after=still)
    assert outline(plots(replace(fine, traces=traces))).tags.count("svg") == 5


def test_the_force_that_is_missing_is_drawn_at_its_places() -> None:
    """Over displacement and speed; only where a filter told it."""
    fine, x = diagnosis(), np.linspace(-1.0, 1.0, 200)
    force = MissingForce("arm.gear", "twist", x, np.cos(9.0 * x), x**3, 0.01 * np.cos(40.0 * x), ("rad", "N m"))
    traces = replace(fine.traces, missing=(force, replace(force, place="arm.motor", what="position")))
    shown = plots(replace(fine, traces=traces))
    assert outline(shown).tags.count("svg") == 6
    assert "Missing force" in shown
    assert "Missing force" not in plots(fine)
    assert all(place in shown for place in ("arm.gear", "arm.motor"))


def test_plots_stay_small_for_long_recordings() -> None:
    assert len(plots(diagnosis(samples=40_000))) < 1_000_000


def test_the_window_is_the_worst_one_and_spans_no_gap() -> None:
    time = np.concatenate([np.arange(100) * 0.1, 50.0 + np.arange(60) * 0.1])
    residual = np.zeros((160, 1))
    residual[97:103] = 1.0  # across the gap
    residual[130:140] = 0.9
    assert runs(time) == [slice(0, 100), slice(100, 160)]
    window = worst_window(time, residual, 20)
    assert window.stop - window.start == 20
    assert window.start <= 130 < 140 <= window.stop


def test_thinning_keeps_order_and_limit() -> None:
    assert thinned(5, 10).tolist() == [0, 1, 2, 3, 4]
    some = thinned(1000, 100)
    assert len(some) == 100
    assert (np.diff(some) > 0).all()


def test_binned_means_follow_a_curve() -> None:
    x = np.random.default_rng(1).uniform(-1.0, 1.0, 4000)
    middle, mean = binned_mean(x, x**2, 40)
    assert len(middle) == 40
    np.testing.assert_allclose(mean, middle**2, atol=2e-3)


def test_numbers_at_the_other_end_of_a_gear_are_shown() -> None:
    beyond = {"shoulder.motor": {"level": Estimate(0.013780, 0.0003, "N m")}}
    rows = findings_table(diagnosis(None, replace(COULOMB, elsewhere=beyond)))
    assert "at shoulder.motor instead" in rows
    assert "0.01378" in rows


def test_what_slides_is_drawn_in_metres() -> None:
    """Where a filter followed it, by the name of its channel."""
    robot = robot_from_text(SLIDE, "slide.toml")
    assert position_units(robot, ("arm", "arm.q", "arm.motor.q", "other")) == ["m", "m", "rad", "rad"]
