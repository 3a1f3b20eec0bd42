"""Two plain laws that one curve of many numbers resembles."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from symdyn.numeric.diagnose import diagnose
from symdyn.numeric.explanation import Explanation
from symdyn.numeric.findings import Verdict
from symdyn.numeric.inquiry import Inquiry
from symdyn.numeric.nested import search_beside
from symdyn.numeric.setting import Setting, prepare
from symdyn.numeric.simple_pair import pairs_instead

from .pendulum import Array, Torque, pendulum, record

SOFT, HARD = 2.0, 1.0  # N m/rad and N m/rad^3
SEED = 4


def springs(t: Array, q: Array, v: Array, a: Array) -> Array:
    return SOFT * q + HARD * q**3


def cam(t: Array, q: Array, v: Array, a: Array) -> Array:
    """A torque that turns over between -1.7 and 0.7 rad, where the pendulum moves."""
    return 0.8 * np.cos(3.2 * q + 0.4)


def told_by_one_curve(missing: Torque, effect: str) -> Inquiry:
    """The explanation by one law that has shapes, as a search would leave it."""
    runs = record(SEED, missing), record(SEED + 100, missing)
    setting: Setting = prepare(pendulum(), *runs, lambda _: None)
    case = setting.case(5.0)
    given: Explanation = case.explain()
    start = Inquiry(setting, case, given, setting, case, given)
    (candidate,) = (c for c in setting.proposed if c.effect == effect)
    search = search_beside(start, given)
    trial = search.polished(search.trial(candidate))
    return dataclasses.replace(start, current=case.explain(((candidate, trial.shapes),), given))


def test_a_curve_gives_way_to_the_two_springs_that_it_resembles() -> None:
    told = told_by_one_curve(springs, "counterbalance_spring")
    inquiry, swapped = pairs_instead(told, told.case.joints, lambda _: None)
    assert swapped
    values = {
        c.effect: f.coefficients[0] for (c, _), f in zip(inquiry.current.found, inquiry.current.fitted, strict=True)
    }
    assert values == {"linear_spring": pytest.approx(SOFT, rel=0.01), "hardening_spring": pytest.approx(HARD, rel=0.02)}
    assert {f.effect for f in inquiry.findings} == values.keys()


def test_a_curve_that_is_there_keeps_its_place() -> None:
    told = told_by_one_curve(cam, "torque_ripple")
    inquiry, swapped = pairs_instead(told, told.case.joints, lambda _: None)
    assert not swapped
    assert [c.effect for c, _ in inquiry.current.found] == ["torque_ripple"]


@pytest.mark.slow  # a whole diagnosis; quick: the exchange alone
def test_a_linear_and_a_hardening_spring_are_named_with_their_values() -> None:
    found = diagnose(pendulum(), record(SEED, springs), record(SEED + 100, springs))
    told = {f.effect: f.parameters["stiffness"] for f in found.findings}
    assert told.keys() == {"linear_spring", "hardening_spring"}
    for effect, value in (("linear_spring", SOFT), ("hardening_spring", HARD)):
        assert told[effect].value == pytest.approx(value, abs=4.0 * (told[effect].se or 0.0))
    assert found.verdict is Verdict.MISSING_PHYSICS
    assert not found.remaining.structured
