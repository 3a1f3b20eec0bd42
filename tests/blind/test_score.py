"""Scores: right by any form with the same equations, placed by an honest group, alarms and silence told apart."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest

from benchmarks.blind.report import facts, markdown
from benchmarks.blind.score import score
from benchmarks.blind.summary import Scored, Share, confusion, joined, kinds, measures, read_scores


def plant(kind: str, place: str, *forms: dict[str, dict[str, float]], **more: Any) -> dict[str, Any]:
    found = {"kind": kind, "place": place, "forms": forms, "also_at": [], "problems": [], "scored": None}
    return {**found, "blemish": False, **more}


def finding(effect: str, place: str, group: tuple[str, ...] = (), **values: tuple[float, float]) -> dict[str, Any]:
    parameters = {name: {"value": value, "se": se, "unit": ""} for name, (value, se) in values.items()}
    return {
        "effect": effect,
        "place": place,
        "group": list(group),
        "parameters": parameters,
        "heldout_gain": 0.1,
        "rivals": [],
    }


def answer(
    *findings: dict[str, Any], verdict: str = "missing_physics", structured: bool = False, after: float = 0.01
) -> dict[str, Any]:
    fit = {"after": {"training": after, "heldout": after}}
    return {"verdict": verdict, "findings": list(findings), "remaining": {"structured": structured}, "fit": fit}


COULOMB = plant("coulomb", "j1", {"coulomb_friction": {"level": 2.0}})
ASYMMETRIC = plant(
    "asymmetric_coulomb",
    "j1",
    {"asymmetric_coulomb_friction": {"level_positive": 3.0, "level_negative": 1.0}},
    {"coulomb_friction": {"level": 2.0}, "force_offset": {"offset": 1.0}},
)


def test_right_name_place_and_value() -> None:
    got = score([COULOMB], answer(finding("coulomb_friction", "j1", level=(2.1, 0.1)), after=0.021), 0.02, 5.0)
    (effect,) = got.effects
    assert (effect.named, effect.placed, got.extra) == (True, True, 0)
    assert effect.errors == pytest.approx({"coulomb_friction.level": 0.05})
    assert effect.covered == {"coulomb_friction.level": True}
    assert got.heldout == pytest.approx(1.05)
    tight = score([COULOMB], answer(finding("coulomb_friction", "j1", level=(2.1, 0.05))), None, 5.0)
    assert tight.effects[0].covered == {"coulomb_friction.level": False}


def test_the_same_equations_in_other_words_are_right() -> None:
    parts = answer(
        finding("coulomb_friction", "j1", level=(2.0, 0.1)), finding("force_offset", "j1", offset=(1.2, 0.1))
    )
    (effect,) = score([ASYMMETRIC], parts, None, 1.0).effects
    assert effect.named
    assert effect.placed
    assert effect.errors == pytest.approx({"coulomb_friction.level": 0.0, "force_offset.offset": 0.2})
    half = score([ASYMMETRIC], answer(finding("coulomb_friction", "j1", level=(2.0, 0.1))), None, 1.0)
    assert not half.effects[0].named
    assert half.effects[0].label == "coulomb_friction"


def test_two_faults_of_one_sensor_are_two_findings() -> None:
    off = plant("encoder_offset", "j1", {"encoder": {"offset": 0.1}})
    coarse = plant("encoder_steps", "j1", {"encoder": {"resolution": 0.01}})
    told = answer(finding("encoder", "j1", offset=(0.1, 0.01)), finding("encoder", "j1", resolution=(0.011, 0.0)))
    got = score([off, coarse], told, None, 1.0)
    assert [e.named for e in got.effects] == [True, True]
    assert got.effects[1].errors == pytest.approx({"encoder.resolution": 0.1})
    assert got.extra == 0


def test_a_group_that_holds_the_place_is_honest() -> None:
    wrong = score([COULOMB], answer(finding("coulomb_friction", "j2", level=(2.0, 0.1))), None, 1.0).effects[0]
    group = score(
        [COULOMB], answer(finding("coulomb_friction", "j2", ("j2", "j1"), level=(2.0, 0.1))), None, 1.0
    ).effects[0]
    assert (wrong.named, wrong.placed) == (True, False)
    assert (group.named, group.placed) == (True, True)


def test_pairs_take_each_finding_once_and_count_what_is_too_much() -> None:
    other = plant("offset", "j2", {"force_offset": {"offset": 1.0}})
    found = answer(
        finding("force_offset", "j2", offset=(1.0, 0.1)),
        finding("coulomb_friction", "j1", level=(2.0, 0.1)),
        finding("quadratic_drag", "j1", coefficient=(1.0, 0.1)),
    )
    got = score([COULOMB, other], found, None, 1.0)
    assert [e.named for e in got.effects] == [True, True]
    assert got.extra == 1
    one = score(
        [COULOMB, other],
        answer(finding("force_offset", "j2", offset=(1.0, 0.1)), finding("quadratic_drag", "j1")),
        None,
        1.0,
    )
    assert [e.named for e in one.effects] == [False, True]
    assert one.effects[0].label == "quadratic_drag"
    assert one.effects[0].placed
    assert one.extra == 0  # it stands for the one that was missed


def test_silence_alarm_and_no_answer_differ() -> None:
    silent = score([COULOMB], answer(verdict="complete"), None, 1.0)
    assert (silent.effects[0].label, silent.alarm, silent.told) == ("nothing", False, False)
    told = score([COULOMB], answer(verdict="unexplained", structured=True), None, 1.0)
    assert (told.effects[0].label, told.alarm, told.told) == ("unexplained", True, True)
    none = score([COULOMB], None, None, 1.0)
    assert (none.effects[0].label, none.answered, none.alarm) == ("no answer", False, False)
    assert score([], answer(finding("force_offset", "j1")), None, 1.0).alarm
    located = {**answer(verdict="unexplained", structured=True), "located": [{"place": "j2", "group": ["j2", "j1"]}]}
    assert score([COULOMB], located, None, 1.0).effects[0].placed


def test_waves_angles_and_products() -> None:
    ripple = plant("ripple", "j1", {"torque_ripple": {"cosine": 0.0, "sine": 2.0, "order": 7.0}})
    found = finding("torque_ripple", "j1", cosine=(0.1, 0.1), sine=(2.0, 0.1), order=(7.0, 0.01))
    (effect,) = score([ripple], answer(found), None, 1.0).effects
    assert effect.errors["torque_ripple.cosine"] == pytest.approx(0.05)  # of the amplitude
    scored = {"mass*eccentricity": 0.2, "phase": 3.1}
    weight = plant("unbalance", "j1", {"unbalance": {"mass": 2.0, "eccentricity": 0.1, "phase": 3.1}}, scored=scored)
    found = finding("unbalance", "j1", mass=(1.0, 0.1), eccentricity=(0.21, 0.1), phase=(-3.1, 0.1))
    (effect,) = score([weight], answer(found), None, 1.0).effects
    assert effect.errors["unbalance.mass*eccentricity"] == pytest.approx(0.05)
    assert effect.errors["unbalance.phase"] == pytest.approx(0.0832, abs=1e-3)
    assert set(effect.covered) == {"unbalance.phase"}


def test_a_rival_is_half_an_answer() -> None:
    found = {
        **finding("stribeck_friction", "j1"),
        "rivals": [{"effect": "coulomb_friction", "place": "j1", "p_value": 0.3}],
    }
    (effect,) = score([COULOMB], answer(found, verdict="ambiguous"), None, 1.0).effects
    assert (effect.named, effect.among_rivals) == (False, True)


def test_a_recording_refused_for_the_right_reason_is_an_answer() -> None:
    late = plant("late_efforts", "", {"channel_skew": {"delay": 0.01}}, problems=["SD529"])
    refused = {**answer(verdict="bad_recording"), "problems": [{"code": "SD529"}]}
    assert score([late], refused, None, 1.0).effects[0].named
    wrong = score([COULOMB], refused, None, 1.0)
    assert (wrong.effects[0].named, wrong.effects[0].label, wrong.alarm) == (False, "bad_recording", True)
    assert score([], refused, None, 1.0).alarm


def test_a_fault_of_the_recording_is_refused_or_lived_with() -> None:
    """What cannot be mended: right is to refuse it for that. What can: as if it were not there."""
    refused = {**answer(verdict="bad_recording"), "problems": [{"code": "SD533"}]}
    flipped, uneven = plant("flipped", "", blemish=True, problems=["SD533"]), plant("uneven", "", blemish=True)
    found = answer(finding("coulomb_friction", "j1", level=(2.0, 0.1)))

    def case(*planted: dict[str, Any], told: dict[str, Any]) -> Scored:
        return Scored("a", "axis", "recording", "middle", score(planted, told, None, 1.0))

    assert case(flipped, told=refused).right
    believed = case(flipped, told=found)
    assert (believed.right, believed.score.effects[0].label) == (False, "missing_physics")
    assert believed.score.extra == 1
    other = {**refused, "problems": [{"code": "SD524"}]}
    assert not case(flipped, told=other).right
    assert case(uneven, told=answer(verdict="complete")).right
    assert not case(uneven, told=found).right
    assert not case(uneven, told=refused).right
    assert case(uneven, COULOMB, told=found).right
    assert not case(uneven, COULOMB, told=refused).right
    assert not case(uneven, COULOMB, told=answer(verdict="complete")).right
    both = [case(flipped, told=refused), case(uneven, told=refused)]
    assert measures(both)["faults of the recording refused, or lived with"] == Share(1, 2)
    assert measures(both)["name right (single and pairs)"] == Share(0, 0)


def test_wilson_intervals() -> None:
    low, high = Share(0, 200).interval
    assert low == pytest.approx(0.0, abs=1e-12)
    assert high == pytest.approx(0.01884, abs=1e-5)
    assert Share(8, 10).interval == pytest.approx((0.4902, 0.9433), abs=1e-4)


def test_the_tables_hold_every_case() -> None:
    found = score([COULOMB], answer(finding("coulomb_friction", "j1", level=(2.0, 0.1))), 0.01, 3.0)
    silent = score([], answer(verdict="complete"), 0.01, 4.0)
    told = score([plant("hum", "j1")], answer(verdict="unexplained", structured=True), None, 5.0)
    cases = [
        Scored("a", "two-link", "single", "middle", found),
        Scored("b", "two-link", "null", "middle", silent),
        Scored("c", "two-link", "unknown", "high", told),
        Scored("d", "six-joint", "null", "low", score([], None, None, 9.0), "error: refused"),
    ]
    assert confusion(cases) == {
        ("coulomb", "coulomb_friction"): 1,
        ("nothing", "nothing"): 1,
        ("hum", "unexplained"): 1,
        ("nothing", "no answer"): 1,
    }
    assert [(row.kind, row.named, row.count) for row in kinds(cases)] == [("coulomb", 1, 1), ("hum", 0, 1)]
    page = markdown(cases, ("tool", "{model}"))
    assert "| name right (single and pairs) | - | 1/1 = 100 % (21 to 100) | - | >= 95 % |" in page
    assert "| unknown effects told as unexplained | - | - | 1/1 = 100 % (21 to 100) | >= 90 % |" in page
    assert "| unknown effects, told and nothing named | - | - | 1/1 = 100 % (21 to 100) |" in page
    assert "| six-joint | error: refused | 1 |" in page
    told_again = read_scores(json.dumps(facts(cases)))
    assert told_again == cases
    better = replace(cases[3], score=silent, error="")
    assert joined(told_again, [better]) == [*cases[:3], better]


def test_a_value_is_that_at_the_place_where_the_effect_was_planted() -> None:
    truth = plant("spring", "j1.motor", {"linear_spring": {"stiffness": 0.002}})
    told = finding("linear_spring", "j1", ("j1", "j1.motor"), stiffness=(1.8, 0.01))
    beyond = told | {"elsewhere": {"j1.motor": {"stiffness": {"value": 0.00201, "se": 0.00001, "unit": ""}}}}
    (silent,), (clear,) = (score([truth], answer(each), None, 5.0).effects for each in (told, beyond))
    assert (silent.placed, silent.covered) == (True, {"linear_spring.stiffness": False})
    assert (clear.placed, clear.covered) == (True, {"linear_spring.stiffness": True})
    assert clear.errors == pytest.approx({"linear_spring.stiffness": 0.005})
    own = told | {"place": "j1.motor", "elsewhere": beyond["elsewhere"]}
    assert score([truth], answer(own), None, 5.0).effects[0].covered == {"linear_spring.stiffness": False}


def test_two_offsets_at_one_place_are_one_offset() -> None:
    offset = plant("offset", "j1", {"force_offset": {"offset": 0.5}})
    told = [finding("coulomb_friction", "j1", level=(2.0, 0.1)), finding("force_offset", "j1", offset=(1.51, 0.01))]
    both = score([ASYMMETRIC, offset], answer(*told), None, 5.0)
    assert [e.covered["force_offset.offset"] for e in both.effects] == [True, True]
    assert both.effects[1].errors["force_offset.offset"] == pytest.approx(0.01 / 1.5)
    apart = score([ASYMMETRIC, {**offset, "place": "j2"}], answer(*told), None, 5.0)
    assert [e.covered["force_offset.offset"] for e in apart.effects] == [False, False]
