"""Numbers and sentences for people."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from symdyn.faces.words import (
    VERDICT_MEANINGS,
    VERDICT_NAMES,
    located_words,
    nats,
    parameter_lines,
    percent,
    probability,
    quantity_text,
    verdict_sentence,
)
from symdyn.numeric.findings import Errors, Estimate, Located, Rival, Verdict

from .fake_diagnosis import COULOMB, RIPPLE, diagnosis, without_findings


@pytest.mark.parametrize(
    ("value", "se", "unit", "text"),
    [
        (203.4412, 1.23, "N s/m", "203.4 ± 1.2 N s/m"),
        (0.2255, 0.00996, "N m", "0.226 ± 0.010 N m"),
        (-0.2255, 0.0041, "N m", "-0.2255 ± 0.0041 N m"),
        (20345.0, 1234.0, "N", "20300 ± 1200 N"),
        (1.152e-5, 3.1e-7, "kg m^2", "(1.152 ± 0.031)e-5 kg m^2"),
        (-2.5e8, 1e6, "N/m", "(-2.500 ± 0.010)e8 N/m"),
        (1e-9, 3.0, "m", "0.0 ± 3.0 m"),
        (-1e-9, 3.0, "m", "0.0 ± 3.0 m"),
        (2e-300, 1e-301, "m", "(2.00 ± 0.10)e-300 m"),
        (0.0, 0.02, "m", "0.000 ± 0.020 m"),
        (11.0, None, "rad/rad", "11"),
        (3.6e-5, None, "kg m^2", "3.6e-5 kg m^2"),
        (1.0e7, 0.0, "", "1e7"),
        (11.0, 2e-15, "rad/rad", "11 ± 2e-15"),
        (1.0, math.inf, "m", "1 m"),
        (math.nan, 1.0, "m", "nan m"),
    ],
)
def test_value_and_error_to_matching_digits(value: float, se: float | None, unit: str, text: str) -> None:
    assert quantity_text(Estimate(value, se, unit)) == text


@given(st.floats(1e-280, 1e280), st.sampled_from([-1, 1]), st.floats(-8.9, 8.9))
def test_what_is_printed_lies_within_the_standard_error(size: float, sign: int, ratio: float) -> None:
    value, se = sign * size, size * 10.0**ratio
    text = quantity_text(Estimate(value, se, ""))
    scale = float("1" + text[text.index(")") + 1 :]) if text.startswith("(") else 1.0
    shown, error = (float(part) * scale for part in text.partition(")")[0].strip("(").split(" ± "))
    assert abs(shown - value) <= 0.06 * se
    assert abs(error - se) <= 0.06 * se


@pytest.mark.parametrize(
    ("x", "text"),
    [
        (0.41, "41 %"), (0.0613, "6.1 %"), (0.09951, "10 %"), (0.0016, "0.16 %"), (0.00063, "0.063 %"),
        (0.000001, "< 0.001 %"), (0.0, "0 %"), (12.5, "1250 %"), (math.nan, "not defined"), (math.inf, "not defined"),
    ],
)  # fmt: skip
def test_percent(x: float, text: str) -> None:
    assert percent(x) == text


def test_probability() -> None:
    assert (probability(1e-9), probability(0.0123), probability(1.0)) == ("p < 0.001", "p = 0.012", "p = 1")


def test_missing_physics_in_one_sentence_and_a_number() -> None:
    told = replace(diagnosis(), before=Errors(0.4, 0.41), after=Errors(0.05, 0.06))
    assert verdict_sentence(told) == (
        "The model lacked torque ripple (cogging) at elbow. Held-out error fell from 41 % to 6.0 %."
    )
    left = replace(told.remaining, structured=True, share=0.3, variable="speed of shoulder")
    assert verdict_sentence(replace(told, remaining=left)).endswith(
        "Part of what is left still follows the speed of shoulder."
    )
    assert verdict_sentence(replace(told, remaining=replace(left, place="elbow"))).endswith(
        "Part of what is left at elbow still follows the speed of shoulder."
    )


def test_other_places_of_its_group_are_said_in_the_sentence() -> None:
    either = replace(COULOMB, group=("shoulder", "elbow"))
    told = verdict_sentence(diagnosis(None, either))
    assert told.startswith("The model lacked Coulomb friction at shoulder or elbow. ")
    unsure = replace(either, rivals=(Rival("viscous_friction", "shoulder", 0.3),))
    told = verdict_sentence(replace(diagnosis(None, unsure), verdict=Verdict.AMBIGUOUS))
    assert told.startswith("The model lacked something at shoulder or elbow that may be Coulomb friction or ")
    left = replace(diagnosis().remaining, structured=True, share=0.6)
    nearest = verdict_sentence(replace(diagnosis(None, either), verdict=Verdict.UNEXPLAINED, remaining=left))
    assert "nearest is Coulomb friction at shoulder or elbow." in nearest


def test_rivals_are_said_in_the_sentence() -> None:
    unsure = replace(RIPPLE, rivals=(Rival("linear_spring", "elbow", 0.3), Rival("force_offset", "shoulder", 0.2)))
    told = verdict_sentence(replace(diagnosis(None, COULOMB, unsure), verdict=Verdict.AMBIGUOUS))
    assert told.startswith(
        "The model lacked Coulomb friction at shoulder, and something at elbow that may be torque ripple (cogging), "
    )
    assert " at shoulder: these recordings do not tell which." in told


def test_no_findings() -> None:
    assert verdict_sentence(without_findings(Verdict.COMPLETE)) == (
        "These recordings show nothing that the model lacks. Held-out error is 7.1 %."
    )
    assert verdict_sentence(without_findings(Verdict.UNEXPLAINED)) == (
        "The model misses something that follows the position of elbow, and no known effect explains it. "
        "Held-out error is 7.1 %."
    )


def test_findings_whose_law_does_not_hold_are_only_the_nearest() -> None:
    left = replace(diagnosis().remaining, structured=True, share=0.6, variable="position of elbow")
    told = verdict_sentence(replace(diagnosis(), verdict=Verdict.UNEXPLAINED, remaining=left))
    assert told.startswith(
        "The model misses something that follows the position of elbow, which no known effect explains; "
        "nearest is torque ripple (cogging) at elbow. Held-out error fell from "
    )
    assert "Part of what is left" not in told


def test_a_place_is_told_with_its_group_and_conditions() -> None:
    place = Located("elbow", ("elbow", "elbow.motor"), 12.0, ("speed", "reversal"))
    assert located_words(place) == "elbow (or elbow.motor): follows speed, reversal"
    assert located_words(replace(place, group=("elbow",), when=())) == "elbow"
    assert [nats(x) for x in (1234.5, 99.96, 11.34, 0.5)] == ["1234", "100", "11.3", "0.5"]


def test_every_verdict_has_words() -> None:
    assert set(VERDICT_NAMES) == set(VERDICT_MEANINGS) == set(Verdict)


def test_numbers_at_other_places_are_told_where_they_differ() -> None:
    same = replace(COULOMB, elsewhere={"shoulder.wheel": COULOMB.parameters})
    assert parameter_lines(same) == ["level = 0.4134 ± 0.0091 N m"]
    geared = replace(same, elsewhere={**same.elsewhere, "shoulder.motor": {"level": Estimate(0.013780, 0.0003, "N m")}})
    assert parameter_lines(geared) == [
        "level = 0.4134 ± 0.0091 N m",
        "at shoulder.motor instead:",
        "  level = 0.01378 ± 0.00030 N m",
    ]
    assert geared.to_json()["elsewhere"]["shoulder.motor"]["level"] == {"value": 0.01378, "se": 0.0003, "unit": "N m"}
